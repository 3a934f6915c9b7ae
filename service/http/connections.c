/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Requests and replies: libmicrohttpd reads and writes; sockets are accepted and timed out here.
 *
 * Its own limits would let silent connections keep others out, and its timeout begins again with
 * each byte. Here a connection is closed that completes nothing for a while, and the one that is
 * silent for longest makes room for a new one.
 */
#include <errno.h>
#include <microhttpd.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "http/connections.h"

#define REQUEST_BYTES 16384 /* of a request's line and headers */
#define ACCEPTS 16          /* in a row */

/* ---- replies ---- */

static void add_header(struct MHD_Response *response, const char *name, const char *value)
{
    (void)MHD_add_response_header(response, name, value);
}

/* Of a page: its own script and style, its own JSON, nothing else. */
static void add_policy(struct MHD_Response *response, const http_reply *r)
{
    char policy[400];
    if (r->nonce[0])
        snprintf(policy, sizeof policy,
                 "default-src 'none'; script-src 'nonce-%s'; style-src 'nonce-%s'; connect-src "
                 "'self'; img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors "
                 "'none'",
                 r->nonce, r->nonce);
    else
        snprintf(policy, sizeof policy, "default-src 'none'; frame-ancestors 'none'");
    add_header(response, "Content-Security-Policy", policy);
}

/* The reply's text is the response's from now on. */
static enum MHD_Result send_reply(struct MHD_Connection *connection, http_reply *r)
{
    struct MHD_Response *response =
        MHD_create_response_from_buffer(r->text ? r->size : 0, r->text ? r->text : (void *)"",
                                        r->text ? MHD_RESPMEM_MUST_FREE : MHD_RESPMEM_PERSISTENT);
    if (!response) {
        free(r->text);
        return MHD_NO;
    }
    add_policy(response, r);
    add_header(response, "Content-Type", r->type ? r->type : "text/plain");
    add_header(response, "X-Content-Type-Options", "nosniff");
    add_header(response, "Referrer-Policy", "no-referrer");
    add_header(response, "Cross-Origin-Resource-Policy", "same-origin");
    add_header(response, "Cache-Control", "no-store");
    if (r->code == MHD_HTTP_METHOD_NOT_ALLOWED)
        add_header(response, "Allow", "GET, HEAD");
    const enum MHD_Result result = MHD_queue_response(connection, r->code, response);
    MHD_destroy_response(response);
    return result;
}

static enum MHD_Result refuse(struct MHD_Connection *connection, unsigned code, const char *text)
{
    http_reply r = {.code = code, .type = "text/plain", .text = strdup(text)};
    r.size = r.text ? strlen(r.text) : 0;
    return send_reply(connection, &r);
}

static http_connection *connection_of(struct MHD_Connection *connection)
{
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(connection, MHD_CONNECTION_INFO_SOCKET_CONTEXT);
    return info ? info->socket_context : NULL;
}

static bool has_body(struct MHD_Connection *connection)
{
    const char *length = MHD_lookup_connection_value(connection, MHD_HEADER_KIND, "Content-Length");
    return (length && strcmp(length, "0") != 0) ||
           MHD_lookup_connection_value(connection, MHD_HEADER_KIND, "Transfer-Encoding");
}

/* Called first when a request's headers are there; a reply at that time ends the connection, so
 * that the body of a refused one is not read. Then once more. */
static enum MHD_Result handle(void *self, struct MHD_Connection *connection, const char *path,
                              const char *method, const char *version, const char *body,
                              size_t *body_size, void **context)
{
    tfa_http *http = self;
    const http_connection *c = connection_of(connection);
    (void)version, (void)body, (void)body_size;
    if (strcmp(method, "GET") != 0 && strcmp(method, "HEAD") != 0)
        return refuse(connection, MHD_HTTP_METHOD_NOT_ALLOWED, "read only: GET and HEAD\n");
    const char *host = MHD_lookup_connection_value(connection, MHD_HEADER_KIND, "Host");
    if (!c || (!c->metrics && !request_host_is_ours(host, http->address)))
        return refuse(connection, MHD_HTTP_MISDIRECTED_REQUEST,
                      "this server is called localhost, or by its number\n");
    if (has_body(connection))
        return refuse(connection, MHD_HTTP_CONTENT_TOO_LARGE, "requests have no body here\n");
    if (!*context) {
        *context = self;
        return MHD_YES;
    }
    http_reply r;
    route_answer(http, c->metrics, path,
                 MHD_lookup_connection_value(connection, MHD_GET_ARGUMENT_KIND, "robot"), &r);
    return send_reply(connection, &r);
}

/* ---- connections ---- */

static void notify(void *self, struct MHD_Connection *connection, void **context,
                   enum MHD_ConnectionNotificationCode code)
{
    tfa_http *http = self;
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD);
    if (code == MHD_CONNECTION_NOTIFY_CLOSED) {
        if (*context)
            ((http_connection *)*context)->socket = -1;
        return;
    }
    for (int i = 0; info && i < HTTP_CONNECTIONS; i++)
        if (http->connections[i].socket == info->connect_fd)
            *context = &http->connections[i];
}

static void complete(void *self, struct MHD_Connection *connection, void **context,
                     enum MHD_RequestTerminationCode code)
{
    http_connection *c = connection_of(connection);
    (void)self, (void)context, (void)code;
    if (c)
        c->since = http_clock();
}

int connections_open(tfa_http *http)
{
    for (int i = 0; i < HTTP_CONNECTIONS; i++)
        http->connections[i].socket = -1;
    http->parser = MHD_start_daemon(
        MHD_USE_EPOLL | MHD_USE_NO_LISTEN_SOCKET, 0, NULL, NULL, handle, http,
        MHD_OPTION_NOTIFY_CONNECTION, notify, http, MHD_OPTION_NOTIFY_COMPLETED, complete, http,
        MHD_OPTION_CONNECTION_MEMORY_LIMIT, (size_t)REQUEST_BYTES, MHD_OPTION_CONNECTION_LIMIT,
        (unsigned)HTTP_CONNECTIONS + 1, MHD_OPTION_STRICT_FOR_CLIENT, 1, MHD_OPTION_END);
    return http->parser ? TFA_OK : TFA_E_SYSTEM;
}

void connections_close(tfa_http *http)
{
    if (http->parser)
        MHD_stop_daemon(http->parser);
    http->parser = NULL;
}

int connections_descriptor(const tfa_http *http)
{
    const union MHD_DaemonInfo *info = MHD_get_daemon_info(http->parser, MHD_DAEMON_INFO_EPOLL_FD);
    return info ? info->epoll_fd : -1;
}

void connections_run(tfa_http *http)
{
    (void)MHD_run(http->parser);
}

uint64_t connections_timeout(const tfa_http *http)
{
    MHD_UNSIGNED_LONG_LONG ms;
    return MHD_get_timeout(http->parser, &ms) == MHD_YES ? ms * 1000000u : UINT64_MAX;
}

/* ---- accepting ---- */

/* The parser sees the end, and closes. */
static void end(http_connection *c)
{
    (void)shutdown(c->socket, SHUT_RDWR);
}

static void end_oldest(tfa_http *http)
{
    http_connection *oldest = NULL;
    for (int i = 0; i < HTTP_CONNECTIONS; i++) {
        http_connection *c = &http->connections[i];
        if (c->socket >= 0 && (!oldest || c->since < oldest->since))
            oldest = c;
    }
    if (!oldest)
        return;
    end(oldest);
    connections_run(http);
}

static http_connection *find_free(tfa_http *http)
{
    for (int i = 0; i < HTTP_CONNECTIONS; i++)
        if (http->connections[i].socket < 0)
            return &http->connections[i];
    return NULL;
}

static http_connection *make_room(tfa_http *http)
{
    if (!find_free(http))
        end_oldest(http);
    return find_free(http);
}

static void add(tfa_http *http, int socket, bool metrics)
{
    const struct sockaddr address = {.sa_family = metrics ? AF_UNIX : AF_INET};
    http_connection *c = make_room(http);
    if (!c) {
        close(socket);
        return;
    }
    *c = (http_connection){.socket = socket, .metrics = metrics, .since = http_clock()};
    if (MHD_add_connection(http->parser, socket, &address, sizeof address) != MHD_YES)
        c->socket = -1; /* closed */
}

/* Without descriptors the listener would stay ready for ever. */
static void wait_for_descriptors(tfa_http *http)
{
    const struct timespec pause = {0, HTTP_PERIOD_NS};
    end_oldest(http);
    (void)nanosleep(&pause, NULL);
}

void connections_accept(tfa_http *http, int listener, bool metrics)
{
    for (int i = 0; i < ACCEPTS; i++) {
        const int socket = accept4(listener, NULL, NULL, SOCK_CLOEXEC | SOCK_NONBLOCK);
        if (socket >= 0)
            add(http, socket, metrics);
        else if (errno == EMFILE || errno == ENFILE || errno == ENOBUFS || errno == ENOMEM)
            wait_for_descriptors(http);
        if (socket < 0)
            return;
    }
}

void connections_sweep(tfa_http *http)
{
    const uint64_t now = http_clock();
    for (int i = 0; i < HTTP_CONNECTIONS; i++) {
        http_connection *c = &http->connections[i];
        if (c->socket >= 0 && now - c->since > HTTP_IDLE_NS)
            end(c);
    }
}
