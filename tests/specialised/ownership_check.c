/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Who may have written a kernel: owners, modes, links, folders above, and what else can lie there.
 */
#include "bench.h"
#include "specialised/specialised_internal.h"
#include "test.h"

#include <sys/stat.h>
#include <unistd.h>

#define OTHER_USER 54321u /* nobody's user */

static int open_group(void **state)
{
    static bench b;
    char path[256];
    bench_open(&b);
    bench_build(&b, b.arm, "SOUND", bench_path(&b, "kernels/kernel.so", path));
    *state = &b;
    return 0;
}

static int close_group(void **state)
{
    bench_close(*state);
    return 0;
}

static void expect(bench *b, int status, const char *error_text)
{
    char path[256];
    assert_int_equal(bench_load(b, bench_path(b, "kernels/kernel.so", path)), status);
    if (error_text)
        bench_assert_error_text(b, error_text);
}

static void change_mode(const bench *b, const char *name, mode_t mode)
{
    char path[256];
    assert_int_equal(chmod(bench_path(b, name, path), mode), 0);
}

TEST(a_file_writable_by_others_is_refused)
{
    bench *b = *state;
    expect(b, TFA_OK, NULL);
    change_mode(b, "kernels/kernel.so", 0664);
    expect(b, TFA_E_REFUSED, "mode 0664");
    change_mode(b, "kernels/kernel.so", 0646);
    expect(b, TFA_E_REFUSED, "chmod go-w");
    change_mode(b, "kernels/kernel.so", 0400);
    expect(b, TFA_OK, NULL);
    change_mode(b, "kernels/kernel.so", 0644);
}

TEST(a_folder_writable_by_others_is_refused)
{
    bench *b = *state;
    change_mode(b, "kernels", 0775);
    expect(b, TFA_E_REFUSED, "kernels' can be written by others (mode 0775)");
    change_mode(b, "kernels", 0757);
    expect(b, TFA_E_REFUSED, "mode 0757");
    change_mode(b, "kernels", 0755);
    expect(b, TFA_OK, NULL);
}

/* A folder above with the sticky bit is good enough, as /tmp is; that of the kernels is not. */
TEST(a_writable_parent_folder_is_refused)
{
    bench *b = *state;
    char path[256];
    change_mode(b, "", 0777);
    expect(b, TFA_E_REFUSED, "mode 0777");
    change_mode(b, "", 01777);
    expect(b, TFA_OK, NULL);
    change_mode(b, "", 0700);
    change_mode(b, "kernels", 01777);
    struct error_text why = {b->error_text, sizeof b->error_text};
    b->error_text[0] = '\0';
    assert_int_equal(check_ownership(bench_path(b, "kernels", path), geteuid(), &why),
                     TFA_E_REFUSED);
    bench_assert_error_text(b, "mode 1777");
    change_mode(b, "kernels", 0755);
}

/* Seen by somebody else these files are a foreigner's, unless they are root's; and those that are
 * given away are a foreigner's to us. */
TEST(other_owners_are_refused)
{
    bench *b = *state;
    char path[256];
    struct error_text why = {b->error_text, sizeof b->error_text};
    bench_path(b, "kernels/kernel.so", path);
    b->error_text[0] = '\0';
    if (geteuid() != 0) {
        assert_int_equal(check_ownership(path, OTHER_USER, &why), TFA_E_REFUSED);
        bench_assert_error_text(b, "neither to root nor to the user");
        return;
    }
    assert_int_equal(check_ownership(path, OTHER_USER, &why), TFA_OK);
    assert_int_equal(chown(path, OTHER_USER, (gid_t)-1), 0);
    expect(b, TFA_E_REFUSED, "belongs to user 54321");
    assert_int_equal(check_ownership(path, OTHER_USER, &why), TFA_OK);
    assert_int_equal(chown(path, 0, (gid_t)-1), 0);
    assert_int_equal(chown(bench_path(b, "kernels", path), OTHER_USER, (gid_t)-1), 0);
    expect(b, TFA_E_REFUSED, "kernels' belongs to user 54321");
    assert_int_equal(chown(path, 0, (gid_t)-1), 0);
    expect(b, TFA_OK, NULL);
}

/* A link is followed, and what counts is where it leads. */
TEST(symbolic_links_are_resolved)
{
    bench *b = *state;
    char path[256], link_at[256];
    bench_path(b, "kernels/kernel.so", path);
    assert_int_equal(symlink(path, bench_path(b, "link.so", link_at)), 0);
    assert_int_equal(bench_load(b, link_at), TFA_OK);
    change_mode(b, "kernels", 0777);
    assert_int_equal(bench_load(b, link_at), TFA_E_REFUSED);
    change_mode(b, "kernels", 0755);
    assert_int_equal(symlink("loop", bench_path(b, "loop", link_at)), 0);
    assert_int_equal(bench_load(b, link_at), TFA_E_FILE);
}

/* None of these is a file, and none makes anybody wait. */
TEST(other_things_are_no_kernels)
{
    bench *b = *state;
    char path[256];
    assert_int_equal(bench_load(b, bench_path(b, "nothing", path)), TFA_E_FILE);
    assert_int_equal(bench_load(b, bench_path(b, "kernels", path)), TFA_E_FILE);
    assert_int_equal(mkfifo(bench_path(b, "fifo", path), 0600), 0);
    assert_int_equal(bench_load(b, path), TFA_E_REFUSED);
    assert_true(bench_load(b, "/dev/null") != TFA_OK);
    bench_write(bench_path(b, "empty", path), "", 0);
    assert_int_equal(bench_load(b, path), TFA_E_PARSE);
}

TEST(arguments_are_checked)
{
    bench *b = *state;
    tfa_specialised *kernel;
    char path[256];
    bench_path(b, "kernels/kernel.so", path);
    assert_int_equal(tfa_specialised_load(NULL, b->arm, &kernel, NULL, 0), TFA_E_ARGUMENT);
    assert_int_equal(tfa_specialised_load(path, NULL, &kernel, NULL, 0), TFA_E_ARGUMENT);
    assert_int_equal(tfa_specialised_load(path, b->arm, NULL, NULL, 0), TFA_E_ARGUMENT);
    assert_int_equal(tfa_specialised_check_ownership(NULL, NULL, 0), TFA_E_ARGUMENT);
    assert_int_equal(tfa_specialised_check_ownership(b->kernels, NULL, 0), TFA_OK);
    char one[1];
    change_mode(b, "kernels/kernel.so", 0666);
    assert_int_equal(tfa_specialised_load(path, b->arm, &kernel, one, 1), TFA_E_REFUSED);
    assert_int_equal(one[0], '\0');
    change_mode(b, "kernels/kernel.so", 0644);
}

int main(void)
{
    return test_run(open_group, close_group);
}
