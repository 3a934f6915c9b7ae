/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The real totalforced under test.
 */
#include "harness.h"
#include "models.h"

#include "test.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <grp.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

static void write_yaml(FILE *out, const char *text)
{
    for (; *text; text++) {
        if (*text == '@')
            fputs(TFA_SOURCE_DIR, out);
        else
            fputc(*text, out);
    }
}

harness harness_make(const char *robots, const char *more)
{
    harness h = {.directory = "/tmp/tfa-test-XXXXXX"};
    assert_non_null(mkdtemp(h.directory));
    snprintf(h.runtime_dir, sizeof h.runtime_dir, "%s/run", h.directory);
    snprintf(h.config, sizeof h.config, "%s/c.yaml", h.directory);
    harness_configure(&h, robots, more);
    return h;
}

void harness_configure(const harness *h, const char *robots, const char *more)
{
    char next[96];
    snprintf(next, sizeof next, "%s.next", h->config);
    FILE *out = fopen(next, "w");
    assert_non_null(out);
    fprintf(out, "runtime_dir: %s\n%srobots:\n", h->runtime_dir, more);
    write_yaml(out, robots);
    if (!strstr(more, "limits:")) /* last: the tests know the lines of the others */
        fputs("limits: {connects_per_second: 100000}\n", out);
    if (!strstr(more, "max_state_us:")) /* no test measures the machine */
        fputs("max_state_us: 0\n", out);
    fclose(out);
    assert_int_equal(rename(next, h->config), 0);
}

void harness_launch(harness *h)
{
    h->pid = fork();
    assert_true(h->pid >= 0);
    if (h->pid != 0)
        return;
    char log[96];
    snprintf(log, sizeof log, "%s/log", h->directory);
    int fd = open(log, O_WRONLY | O_CREAT | O_APPEND, 0600);
    (void)dup2(fd, STDERR_FILENO);
    (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
    unsetenv("NOTIFY_SOCKET");
    if (h->notify[0]) {
        setenv("NOTIFY_SOCKET", h->notify, 1);
        setenv("WATCHDOG_USEC", "200000", 1);
    }
    if (h->preload[0])
        setenv("LD_PRELOAD", h->preload, 1);
    execl(TFA_BINARY_DIR "/bin/totalforced", "totalforced", h->config, (char *)NULL);
    _exit(127);
}

/* The end of it. */
static void show_log(const harness *h)
{
    char path[96], text[16384];
    snprintf(path, sizeof path, "%s/log", h->directory);
    FILE *in = fopen(path, "r");
    if (!in)
        return;
    (void)!fseek(in, -(long)sizeof text, SEEK_END); /* a shorter log: stays at its beginning */
    const size_t n = fread(text, 1, sizeof text, in);
    fclose(in);
    (void)!write(STDERR_FILENO, text, n); /* print_error would cut it */
}

void harness_start(harness *h, const char *robot)
{
    char socket[160];
    snprintf(socket, sizeof socket, "%s/%s.sock", h->runtime_dir, robot);
    harness_launch(h);
    const tfa_client_options options = harness_options(h, robot);
    tfa_client *client = NULL;
    bool ended = false;
    (void)WAIT_FOR((access(socket, F_OK) == 0 && tfa_client_connect(&options, &client) == TFA_OK) ||
                   (ended = waitpid(h->pid, NULL, WNOHANG) == h->pid));
    tfa_client_close(client);
    if (client)
        return;
    show_log(h);
    h->pid = ended ? 0 : h->pid;
    fail_msg("the daemon did not start");
}

static int wait_end(harness *h)
{
    int status = -1;
    if (WAIT_FOR(waitpid(h->pid, &status, WNOHANG) == h->pid)) {
        h->pid = 0;
        return status;
    }
    show_log(h);
    fail_msg("the daemon did not end");
    return -1;
}

harness harness_serve(const char *robots, const char *more)
{
    harness h = harness_make(robots, more);
    harness_start(&h, "arm");
    return h;
}

int harness_run(harness *h)
{
    harness_launch(h);
    return wait_end(h);
}

void harness_assert_refused(harness *h, const char *reason)
{
    const int status = harness_run(h);
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 2);
    if (!harness_logged(h, reason))
        fail_msg("'%s' is not said", reason);
}

int harness_check(const harness *h)
{
    char command[512];
    snprintf(command, sizeof command, "%s/bin/totalforced --check %s 2>>%s/log", TFA_BINARY_DIR,
             h->config, h->directory);
    const int status = system(command);
    assert_true(WIFEXITED(status));
    return WEXITSTATUS(status);
}

void harness_assert_mistake(harness *h, const char *reason)
{
    assert_int_equal(harness_check(h), 2);
    if (!harness_logged(h, reason))
        fail_msg("--check does not say '%s'", reason);
    const unsigned said = harness_log_lines(h, reason);
    harness_assert_refused(h, reason);
    assert_true(harness_log_lines(h, reason) > said);
}

void harness_reload(const harness *h, const char *robots, const char *more)
{
    if (robots)
        harness_configure(h, robots, more);
    assert_int_equal(kill(h->pid, SIGHUP), 0);
}

void harness_write(const harness *h, const char *name, const char *text)
{
    char path[160];
    snprintf(path, sizeof path, "%s/%s", h->directory, name);
    FILE *out = fopen(path, "w");
    assert_non_null(out);
    fputs(text, out);
    assert_int_equal(fclose(out), 0);
}

static struct sockaddr_un address_of(const char *directory, const char *name)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    snprintf(address.sun_path, sizeof address.sun_path, "%.80s/%.24s", directory, name);
    return address;
}

int harness_dial(const harness *h, const char *name)
{
    const struct sockaddr_un address = address_of(h->runtime_dir, name);
    const int fd = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
    assert_int_equal(connect(fd, (const struct sockaddr *)&address, sizeof address), 0);
    return fd;
}

int socket_at(const char *directory, const char *name, int type, bool listens)
{
    const struct sockaddr_un address = address_of(directory, name);
    const int fd = socket(AF_UNIX, type | SOCK_CLOEXEC, 0);
    assert_int_equal(bind(fd, (const struct sockaddr *)&address, sizeof address), 0);
    assert_int_equal(listens ? listen(fd, 16) : 0, 0);
    return fd;
}

bool become_user(uid_t user)
{
    const gid_t nogroup = 65534;
    return setgroups(0, NULL) == 0 && setgid(nogroup) == 0 && setuid(user) == 0;
}

int child_end(pid_t child)
{
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

int harness_stop(harness *h, int signal)
{
    kill(h->pid, signal);
    const int status = wait_end(h);
    if (WIFEXITED(status) && WEXITSTATUS(status) != 0)
        show_log(h); /* a sanitizer's report, too */
    return status;
}

void harness_pause(const harness *h)
{
    int status;
    assert_int_equal(kill(h->pid, SIGSTOP), 0);
    assert_int_equal(waitpid(h->pid, &status, WUNTRACED), h->pid);
    assert_true(WIFSTOPPED(status));
}

static void remove_all(const char *directory)
{
    char path[512];
    DIR *d = opendir(directory);
    if (!d)
        return;
    for (const struct dirent *e; (e = readdir(d)) != NULL;) {
        struct stat info;
        if (strcmp(e->d_name, ".") == 0 || strcmp(e->d_name, "..") == 0)
            continue;
        snprintf(path, sizeof path, "%s/%s", directory, e->d_name);
        if (lstat(path, &info) == 0 && S_ISDIR(info.st_mode))
            remove_all(path);
        else
            unlink(path);
    }
    closedir(d);
    rmdir(directory);
}

void harness_remove(harness *h)
{
    if (h->pid > 0) {
        (void)kill(h->pid, SIGCONT);
        assert_int_equal(harness_stop(h, SIGTERM), 0);
    }
    remove_all(h->directory);
}

tfa_client_options harness_options(const harness *h, const char *robot)
{
    return (tfa_client_options){
        .runtime_dir = h->runtime_dir, .robot = robot, .connect_timeout_ms = WAIT_MS};
}

tfa_client *harness_connect(const harness *h, const char *robot, tfa_wait wait)
{
    tfa_client_options options = harness_options(h, robot);
    options.wait = wait;
    return harness_connect_with(&options);
}

tfa_client *harness_connect_with(const tfa_client_options *options)
{
    tfa_client *client;
    assert_int_equal(tfa_client_connect(options, &client), TFA_OK);
    return client;
}

int harness_named_segments(const harness *h)
{
    char path[64], target[256];
    int count = 0;
    snprintf(path, sizeof path, "/proc/%d/fd", (int)h->pid);
    DIR *d = opendir(path);
    assert_non_null(d);
    for (const struct dirent *e; (e = readdir(d)) != NULL;) {
        const ssize_t length = readlinkat(dirfd(d), e->d_name, target, sizeof target - 1);
        target[length > 0 ? length : 0] = 0;
        count += strncmp(target, "/dev/shm/", 9) == 0 && !strstr(target, " (deleted)");
    }
    closedir(d);
    return count;
}

static unsigned count_clients(const harness *h)
{
    static char text[65536];
    unsigned count = 0;
    assert_int_equal(tfa_daemon_command(h->runtime_dir, "status", WAIT_MS, text, sizeof text),
                     TFA_OK);
    for (const char *at = text; (at = strstr(at, "\"user\": ")) != NULL; at++)
        count++;
    return count;
}

bool harness_has_clients(const harness *h, unsigned count)
{
    return WAIT_FOR(count_clients(h) == count);
}

int harness_descriptors(const harness *h)
{
    char path[64];
    int count = 0;
    snprintf(path, sizeof path, "/proc/%d/fd", (int)h->pid);
    DIR *d = opendir(path);
    assert_non_null(d);
    while (readdir(d))
        count++;
    closedir(d);
    return count - 2;
}

void harness_assert_descriptors(const harness *h, int most)
{
    int now;
    if (!WAIT_FOR((now = harness_descriptors(h)) <= most))
        fail_msg("%d descriptors, at most %d", now, most);
}

int harness_mappings(const harness *h)
{
    char path[64];
    int count = 0;
    snprintf(path, sizeof path, "/proc/%d/maps", (int)h->pid);
    FILE *in = fopen(path, "r");
    assert_non_null(in);
    for (int c; (c = fgetc(in)) != EOF;)
        count += c == '\n';
    fclose(in);
    return count;
}

long harness_resident_kib(const harness *h)
{
    char path[64];
    long pages = 0;
    snprintf(path, sizeof path, "/proc/%d/statm", (int)h->pid);
    FILE *in = fopen(path, "r");
    assert_non_null(in);
    assert_int_equal(fscanf(in, "%*d %ld", &pages), 1);
    fclose(in);
    return pages * (sysconf(_SC_PAGESIZE) / 1024);
}

unsigned harness_log_lines(const harness *h, const char *text)
{
    char path[96];
    char *line = NULL;
    size_t size = 0;
    unsigned found = 0;
    snprintf(path, sizeof path, "%s/log", h->directory);
    FILE *in = fopen(path, "r");
    if (!in)
        return 0;
    while (getline(&line, &size, in) > 0)
        found += strstr(line, text) != NULL;
    free(line);
    fclose(in);
    return found;
}

bool harness_logged_times(const harness *h, const char *text, unsigned times)
{
    if (WAIT_FOR(harness_log_lines(h, text) >= times))
        return true;
    show_log(h);
    return false;
}

bool harness_logged(const harness *h, const char *text)
{
    return harness_logged_times(h, text, 1);
}

static long faults_of(const char *task, const char *thread)
{
    char path[512], name[32];
    long faults = -1;
    snprintf(path, sizeof path, "%s/stat", task);
    FILE *in = fopen(path, "r");
    if (!in)
        return -1;
    if (fscanf(in, "%*d (%31[^)]) %*c %*d %*d %*d %*d %*d %*u %ld", name, &faults) != 2 ||
        strcmp(name, thread) != 0)
        faults = -1;
    fclose(in);
    return faults;
}

long harness_thread_faults(const harness *h, const char *thread)
{
    char path[64], task[384];
    long faults = -1;
    snprintf(path, sizeof path, "/proc/%d/task", (int)h->pid);
    DIR *d = opendir(path);
    assert_non_null(d);
    for (const struct dirent *e; faults < 0 && (e = readdir(d)) != NULL;) {
        snprintf(task, sizeof task, "%s/%s", path, e->d_name);
        if (e->d_name[0] != '.')
            faults = faults_of(task, thread);
    }
    closedir(d);
    return faults;
}

tfa_request arm_request(double x, double q[7], double v[7], double tau[7])
{
    for (int i = 0; i < 7; i++) {
        q[i] = x + 0.1 * i;
        v[i] = 0.3 * x - 0.2 * i;
        tau[i] = 1 - 0.1 * i;
    }
    return request_fd(q, v, tau);
}

int ask_arm(tfa_client *client, double x, double qdd[7], uint64_t timeout_ns)
{
    double q[7], v[7], tau[7];
    const tfa_request request = arm_request(x, q, v, tau);
    tfa_reply reply = {.qdd = qdd};
    return tfa_client_call(client, &request, &reply, timeout_ns, NULL);
}
