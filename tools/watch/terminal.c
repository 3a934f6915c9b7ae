/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * A terminal that a program shows a page on: plain ANSI sequences.
 */
#include "watch.h"

#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <string.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#define OTHER_SCREEN "\033[?1049h\033[?25l" /* and no cursor */
#define OWN_SCREEN "\033[?25h\033[?1049l"
#define HOME "\033[H"
#define END_OF_LINE "\033[K"
#define END_OF_SCREEN "\033[J"

static struct termios before;
static bool is_open;
static volatile sig_atomic_t resized, ended;

static void on_signal(int number)
{
    if (number == SIGWINCH)
        resized = 1;
    else
        ended = 1;
}

static void write_all(const char *text, size_t size)
{
    while (size) {
        const ssize_t n = write(STDOUT_FILENO, text, size);
        if (n < 0 && errno != EINTR && errno != EAGAIN) {
            ended = 1;
            return;
        }
        text += n > 0 ? n : 0;
        size -= n > 0 ? (size_t)n : 0;
    }
}

/* poll is interrupted by them. */
static void catch_signals(void)
{
    static const int numbers[] = {SIGWINCH, SIGINT, SIGTERM, SIGHUP, SIGQUIT};
    struct sigaction action = {.sa_handler = on_signal};
    sigemptyset(&action.sa_mask);
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
        sigaction(numbers[i], &action, NULL);
}

bool terminal_open(void)
{
    if (tcgetattr(STDIN_FILENO, &before) != 0)
        return false;
    struct termios raw = before;
    raw.c_lflag &= (tcflag_t) ~(ICANON | ECHO | ISIG); /* Ctrl-C is a key, too */
    raw.c_cc[VMIN] = 1;
    raw.c_cc[VTIME] = 0;
    catch_signals();
    if (tcsetattr(STDIN_FILENO, TCSANOW, &raw) != 0)
        return false;
    is_open = true;
    write_all(OTHER_SCREEN, sizeof OTHER_SCREEN - 1);
    return true;
}

void terminal_close(void)
{
    if (!is_open)
        return;
    is_open = false;
    write_all(OWN_SCREEN, sizeof OWN_SCREEN - 1);
    (void)tcsetattr(STDIN_FILENO, TCSANOW, &before);
}

static struct winsize size_of_terminal(void)
{
    struct winsize size = {0};
    if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_row == 0 || size.ws_col == 0)
        size = (struct winsize){.ws_row = 24, .ws_col = 80};
    return size;
}

/* Lines that do not fit are left out, and so is the end of long ones. */
void terminal_show(const char *text)
{
    const struct winsize size = size_of_terminal();
    write_all(HOME, sizeof HOME - 1);
    for (unsigned row = 0; row < size.ws_row && *text; row++) {
        const size_t length = strcspn(text, "\n");
        if (row)
            write_all("\r\n", 2);
        write_all(text, length < size.ws_col ? length : size.ws_col);
        if (length < size.ws_col)
            write_all(END_OF_LINE, sizeof END_OF_LINE - 1);
        text += length + (text[length] == '\n');
    }
    write_all(END_OF_SCREEN, sizeof END_OF_SCREEN - 1);
}

terminal_event terminal_wait(int timeout_ms, char *key)
{
    struct pollfd keys = {.fd = STDIN_FILENO, .events = POLLIN};
    if (!ended && !resized && poll(&keys, 1, timeout_ms) > 0)
        return read(STDIN_FILENO, key, 1) == 1 ? TERMINAL_KEY : TERMINAL_END;
    if (ended)
        return TERMINAL_END;
    if (!resized)
        return TERMINAL_TIME;
    resized = 0;
    return TERMINAL_RESIZED;
}
