/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The file that a robot's name stands for: packages of ROS, file URIs, the home folder. Reads the
 * environment and asks whether folders exist; runs nothing.
 */
#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <totalforce/description.h>

/* Writes the path (error 0), or the reason why there is none, and sets errno. */
__attribute__((format(printf, 4, 5))) static int finish(int error, char *text, size_t size,
                                                        const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    const int length = vsnprintf(text, size, format, arguments);
    va_end(arguments);
    if (!error && (length < 0 || (size_t)length >= size)) {
        snprintf(text, size, "the name is longer than %zu bytes", size - 1);
        error = ENAMETOOLONG;
    }
    errno = error;
    return error ? TFA_E_FILE : TFA_OK;
}

static int is_folder(const char *path)
{
    struct stat info;
    return stat(path, &info) == 0 && S_ISDIR(info.st_mode);
}

/* The first of the folders in a list with colons that has the package below `middle`. */
static int find_in(const char *list, const char *middle, const char *package, int length,
                   char *folder, size_t size)
{
    while (list && *list) {
        const int entry = (int)strcspn(list, ":");
        const int used = snprintf(folder, size, "%.*s%s%.*s", entry, list, middle, length, package);
        if (entry && used > 0 && (size_t)used < size && is_folder(folder))
            return 1;
        list += entry + (list[entry] == ':');
    }
    return 0;
}

static const char *or_unset(const char *value)
{
    return value && *value ? value : "not set";
}

/* "NAME/PATH", or with the end ')' "NAME)/PATH" */
static int find_package(const char *name, char end, char *path, size_t size)
{
    const char *ament = getenv("AMENT_PREFIX_PATH"), *ros = getenv("ROS_PACKAGE_PATH");
    const char *package = name + strspn(name, " ");
    const int length = (int)strcspn(package, "/ )");
    const char *rest = package + length;
    char folder[TFA_URDF_PATH_MAX];
    rest += strspn(rest, " ");
    if (!length || (end == ')' ? *rest != ')' : *rest != '/'))
        return finish(ENOENT, path, size, "'%.200s' names no package%s", name,
                      end == ')' ? "; write $(find PACKAGE)/FILE" : " and file");
    if (find_in(ament, "/share/", package, length, folder, sizeof folder) ||
        find_in(ros, "/", package, length, folder, sizeof folder))
        return finish(0, path, size, "%s%s", folder, rest + (end == ')'));
    return finish(ENOENT, path, size,
                  "no package '%.*s' in AMENT_PREFIX_PATH (%.600s) or ROS_PACKAGE_PATH (%.600s); "
                  "source the setup file of its workspace, or write the file's path",
                  length > 200 ? 200 : length, package, or_unset(ament), or_unset(ros));
}

/* What follows "file:": "//host/PATH" of this host, or a path; %XX is a byte. */
static int find_uri(const char *uri, char *path, size_t size)
{
    size_t used = 0;
    const char *from = strncmp(uri, "//localhost/", 12) == 0 ? uri + 11
                       : strncmp(uri, "//", 2) == 0          ? uri + 2
                                                             : uri;
    if (*from != '/')
        return finish(ENOENT, path, size,
                      "a file URI of another host; file:///PATH is of this one");
    while (*from && used + 1 < size) {
        unsigned byte = 0;
        int digits = 0;
        if (*from == '%' && sscanf(from + 1, "%2x%n", &byte, &digits) == 1 && digits == 2 && byte)
            from += 3;
        else
            byte = (unsigned char)*from++;
        path[used++] = (char)byte;
    }
    path[used] = '\0';
    return *from ? finish(ENAMETOOLONG, path, size, "the name is longer than %zu bytes", size - 1)
                 : TFA_OK;
}

int tfa_urdf_find(const char *name, char *path, size_t size)
{
    static const struct {
        const char *start;
        char end;
    } packages[] = {{"package://", '/'}, {"$(find ", ')'}, {"$(find-pkg-share ", ')'}};
    if (!name || !path || size == 0)
        return TFA_E_ARGUMENT;
    for (size_t k = 0; k < sizeof packages / sizeof *packages; k++) {
        const size_t length = strlen(packages[k].start);
        if (strncmp(name, packages[k].start, length) == 0)
            return find_package(name + length, packages[k].end, path, size);
    }
    if (strncmp(name, "file:/", 6) == 0)
        return find_uri(name + 5, path, size);
    if (name[0] == '~' && (name[1] == '/' || !name[1])) {
        const char *home = getenv("HOME");
        return home && *home ? finish(0, path, size, "%s%s", home, name + 1)
                             : finish(ENOENT, path, size, "~: HOME is not set");
    }
    if (strncmp(name, "$(", 2) == 0 || strstr(name, "://") || (name[0] == '~' && strchr(name, '/')))
        return finish(ENOENT, path, size,
                      "'%.*s...' is not expanded; a path, ~/FILE, file:///PATH, "
                      "package://PACKAGE/FILE and $(find PACKAGE)/FILE are",
                      (int)strcspn(name, "/)") + 1, name);
    return finish(0, path, size, "%s", name);
}
