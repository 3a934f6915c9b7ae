/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * The protocol of the ring (lib/ipc/ring.h) between one client, one worker and the control thread,
 * for SPIN. Each statement is one step of one thread; the labels are those of ring.h and worker.h.
 *
 *   SLOTS, REQUESTS   size of the ring; requests that the client sends in all
 *   CLIENT_CRASHES, DAEMON_CRASHES   at most so many of each
 *   SPIN_MODE         both sides agreed never to sleep: no flags, no wake-ups
 *   MUTATE_x          one fault of mutations.txt
 *
 * Time-outs do not exist: a lost wake-up is a deadlock. The time slice of the client's futex wait
 * appears only as its purpose, the notice that the daemon hung up.
 * A sequence number is a byte and the futex word its two lower bits, so that the word wraps.
 */
#ifndef SLOTS
#define SLOTS 2
#endif
#ifndef REQUESTS
#define REQUESTS 5
#endif
#ifndef CLIENT_CRASHES
#define CLIENT_CRASHES 1
#endif
#ifndef DAEMON_CRASHES
#define DAEMON_CRASHES 1
#endif

#define FUTEX_WORD(seq) ((seq) & 3)
#define NONE 255
#define BEFORE(index) ((index) < SLOTS -> 0 : (index) + 1 - SLOTS) /* seq of the lap before */

mtype:entry = { FREE, ATTACHED, DETACHING, DETACHED }
mtype:socket = { CLOSED, HELLO, ANSWERING, WELCOME }
mtype:fate = { UNSENT, SENT, DONE }

/* ---- shared memory ---- */
byte request_seq[SLOTS], request_id[SLOTS]; /* written by the client */
byte reply_seq[SLOTS], reply_id[SLOTS];     /* written by the worker */
bit client_asleep;                          /* A4, R4 */
bit worker_asleep;                          /* A3, R3 */

/* ---- kernel ---- */
bit doorbell, wake_event;      /* eventfds, edge triggered: set until the next epoll_wait */
byte futex = NONE;             /* slot whose reply word the client sleeps on */
mtype:socket socket = CLOSED;  /* of the living client */
bit hangup;                    /* the control thread has yet to see that a client died */
bit hung_up;                   /* the client has yet to see that the daemon died */
bit kill_client, kill_worker, kill_control;

/* ---- the worker's entry of the client ---- */
mtype:entry entry = FREE;
byte next_request;
bit mapped; /* the daemon's mapping of both segments */

/* ---- the client ---- */
byte sent, received;
byte first_id, lost, lost_end;

/* ---- what the proof remembers ---- */
bit request_writing[SLOTS], request_reading[SLOTS];
bit reply_writing[SLOTS], reply_reading[SLOTS];
mtype:fate fate[REQUESTS] = UNSENT;
byte pending; /* requests published without a status */

#define WORK (entry == ATTACHED && request_seq[next_request % SLOTS] == next_request + 1)
#define WORKER_MISSES (Worker@end_asleep && WORK)
#define CLIENT_MISSES (futex != NONE && reply_seq[futex % SLOTS] == received + 1)

ltl answered { [] (pending > 0 -> <> (pending == 0)) }
ltl worker_wakes { [] (WORKER_MISSES -> <> !WORKER_MISSES) }
ltl client_wakes { [] (CLIENT_MISSES -> <> !CLIENT_MISSES) }

/* ---- the client ---- */

inline write_request()
{
    d_step { assert(!request_reading[slot]); request_writing[slot] = 1 }
    d_step { request_id[slot] = first_id + sent; request_writing[slot] = 0 }
}

/* Ghosts: from its publication on, the request has to get a status. */
inline publish_request()
{
    d_step {
        assert(fate[first_id + sent] == UNSENT);
        fate[first_id + sent] = SENT;
        pending++;
#ifdef MUTATE_REQUEST_SEQ_WITHOUT_ONE
        request_seq[slot] = sent;
#else
        request_seq[slot] = sent + 1; /* A1 */
#endif
        sent++
    }
}

#ifdef MUTATE_CLIENT_READS_FLAG_EARLY
#define WORKER_FLAG flag
#else
#define WORKER_FLAG worker_asleep
#endif

inline send_request()
{
    slot = sent % SLOTS;
#ifdef MUTATE_REQUEST_PUBLISHED_EARLY
    atomic { publish_request(); sent-- };
    write_request();
    sent++;
#else
    write_request();
#ifdef MUTATE_CLIENT_READS_FLAG_EARLY
    flag = worker_asleep;
#endif
    publish_request(); /* A1 */
#endif
#if !defined(SPIN_MODE) && !defined(MUTATE_NO_DOORBELL)
    if
    :: WORKER_FLAG -> doorbell = 1 /* R3 */
    :: else
    fi
#endif
}

inline set_done(id)
{
    assert(fate[id] == SENT);
    fate[id] = DONE;
    pending--
}

#ifdef MUTATE_REPLY_OF_ANY_LAP
#define REPLY_READY(seq) ((seq) != 0)
#else
#define REPLY_READY(seq) ((seq) == received + 1)
#endif

#ifdef MUTATE_NO_LIVENESS_CHECK
#define HUNG_UP_UNSEEN true
#else
#define HUNG_UP_UNSEEN !hung_up
#endif

/* Reads the oldest reply, which has come, and releases its slot. */
inline read_reply()
{
    slot = received % SLOTS;
#ifdef MUTATE_RELEASED_EARLY
    /* the slot counts as free while its reply is not read yet, and the next request goes out */
    if
    :: sent - received == SLOTS && first_id + sent < REQUESTS ->
        received++;
        send_request();
        received--;
        slot = received % SLOTS
    :: else
    fi;
#endif
    d_step { assert(!reply_writing[slot]); reply_reading[slot] = 1 }
    d_step {
        assert(reply_id[slot] == first_id + received); /* reply i answers request i */
        set_done(first_id + received);
        reply_reading[slot] = 0;
        received++
    }
}

/* As mark_requests_lost of client.c. */
inline mark_requests_lost()
{
    d_step {
#ifndef MUTATE_LOST_NOT_REPORTED
        if
        :: received < sent ->
            if
            :: lost == lost_end -> lost = first_id + received
            :: else
            fi;
            lost_end = first_id + sent
        :: else
        fi;
#endif
#ifdef MUTATE_IDS_REUSED
        first_id = first_id + received;
#else
        first_id = first_id + sent;
#endif
        sent = 0;
        received = 0;
        hung_up = 0;
        socket = CLOSED
    }
}

/* The kernel compares the word and sleeps in one step. */
inline futex_wait()
{
#ifdef MUTATE_FUTEX_STALE_VALUE
    value = reply_seq[slot];
#endif
    atomic {
        if
#ifndef MUTATE_FUTEX_WITHOUT_COMPARISON
        :: FUTEX_WORD(reply_seq[slot]) != FUTEX_WORD(value) -> skip
#endif
        :: else -> futex = slot
        fi
    }
    atomic {
#ifdef MUTATE_NO_LIVENESS_CHECK
        (futex == NONE);
#else
        (futex == NONE || hung_up);
#endif
        futex = NONE
    }
}

active proctype Client()
{
    byte slot, value;
    #ifdef MUTATE_CLIENT_READS_FLAG_EARLY
    bit flag;
#endif
start:
    {
        socket = HELLO;
        (socket == WELCOME);
        do
        :: lost != lost_end -> d_step { set_done(lost); lost++ } /* TFA_E_LOST */
#ifdef MUTATE_FULL_OFF_BY_ONE
        :: first_id + sent < REQUESTS && sent - received <= SLOTS -> send_request()
#else
        :: first_id + sent < REQUESTS && sent - received < SLOTS -> send_request()
#endif
        :: lost == lost_end && received < sent ->
            slot = received % SLOTS;
wait:
            if
            :: REPLY_READY(reply_seq[slot]) -> goto ready /* R2 */
            :: else
            fi;
            if
#ifndef MUTATE_NO_LIVENESS_CHECK
            :: hung_up -> goto last_look
#endif
            :: HUNG_UP_UNSEEN -> goto wait /* spins; R5 decides nothing and is left out */
#ifndef SPIN_MODE
            :: goto sleep
#endif
            fi;
sleep:
#ifdef VARIANT_CLIENT_FLAG_AFTER_RECHECK
            value = reply_seq[slot];
            client_asleep = 1;
#else
            client_asleep = 1;        /* A4 */
            value = reply_seq[slot];  /* R2 */
#endif
#ifndef MUTATE_FUTEX_STALE_VALUE
            if
            :: REPLY_READY(value) -> goto awake
            :: else
            fi;
#endif
            futex_wait();
            if
            :: REPLY_READY(reply_seq[slot]) -> goto awake /* R2 */
            :: else
            fi;
            if
            :: hung_up -> client_asleep = 0; goto last_look
            :: else -> goto sleep
            fi;
awake:
            client_asleep = 0; /* A4 */
            goto ready;
last_look: /* after the hang-up: a reply may have come before it */
            if
            :: REPLY_READY(reply_seq[slot]) -> goto ready /* R2 */
            :: else
            fi;
            mark_requests_lost();
            goto start;
ready:
            read_reply()
        :: hung_up -> /* seen when it sends into a full ring, or asked to reconnect */
            mark_requests_lost();
            goto start
        :: lost == lost_end && received == sent && first_id + sent == REQUESTS -> break
        od;
        /* each request was answered once, or reported lost, or its client died */
        atomic {
            for (slot : 0 .. REQUESTS - 1) {
                assert(fate[slot] == DONE)
            }
            assert(pending == 0)
        }
        goto end_done
    } unless { atomic { kill_client ->
        /* dies; another client takes its place */
        kill_client = 0;
        if
        :: socket == ANSWERING || (socket == WELCOME && !hung_up) -> hangup = 1
        :: else
        fi;
        for (slot : 0 .. REQUESTS - 1) {
            if
            :: fate[slot] == SENT -> fate[slot] = DONE
            :: else
            fi
        }
        pending = 0; lost = 0; lost_end = 0; hung_up = 0; futex = NONE;
        first_id = first_id + sent; /* ids that no request had, to tell the clients apart */
        sent = 0; value = 0; slot = 0;
        socket = CLOSED;
        goto start
    } };
end_done:
    (false)
}

/* ---- the worker ---- */

inline write_reply()
{
    d_step { assert(mapped && !reply_reading[slot]); reply_writing[slot] = 1 }
    d_step { reply_id[slot] = scratch; reply_writing[slot] = 0 }
}

#ifdef MUTATE_WORKER_READS_FLAG_EARLY
#define CLIENT_FLAG flag
#else
#define CLIENT_FLAG client_asleep
#endif
#ifdef MUTATE_WAKES_OTHER_WORD
#define WOKEN_SLOT ((slot + 1) % SLOTS)
#else
#define WOKEN_SLOT slot
#endif

inline wake_client()
{
    if
    :: CLIENT_FLAG -> d_step { /* R4 */
            assert(mapped);
            if
            :: futex == WOKEN_SLOT -> futex = NONE
            :: else
            fi
        }
    :: else
    fi
}

inline publish_reply()
{
    d_step {
        assert(mapped);
        assert(next_request < received + SLOTS); /* replies do not overflow */
#ifdef MUTATE_REPLY_SEQ_WITHOUT_ONE
        reply_seq[slot] = next_request;
#else
        reply_seq[slot] = next_request + 1; /* A2 */
#endif
        next_request++
    }
}

inline serve()
{
    d_step { assert(mapped && !request_writing[slot]); request_reading[slot] = 1 }
    d_step { assert(mapped); scratch = request_id[slot]; request_reading[slot] = 0 }
#ifdef MUTATE_REPLY_PUBLISHED_EARLY
    publish_reply();
    write_reply();
#else
    write_reply();
#ifdef MUTATE_WORKER_READS_FLAG_EARLY
    flag = client_asleep;
#endif
    publish_reply(); /* A2 */
#endif
#if !defined(SPIN_MODE) && !defined(MUTATE_MODES_DISAGREE) && !defined(MUTATE_NO_FUTEX_WAKE)
    wake_client();
#endif
    scratch = 0
    /* A5 follows in the cycle: it decides nothing and is left out */
}

active proctype Worker()
{
    byte slot, scratch;
#ifdef MUTATE_WORKER_READS_FLAG_EARLY
    bit flag;
#endif
start:
    {
        if
        :: entry == DETACHING -> d_step { /* R7 */
                if
                :: entry == DETACHING -> entry = DETACHED /* A8, compare and exchange */
                :: else
                fi
            }
        :: atomic { entry == ATTACHED -> slot = next_request % SLOTS; assert(mapped) } /* R6 */
            if
#ifdef MUTATE_REQUEST_OF_ANY_LAP
            :: request_seq[slot] != 0 ->
#else
            :: request_seq[slot] == next_request + 1 -> /* R1 */
#endif
                serve();
                goto start
            :: request_seq[slot] == BEFORE(next_request) -> skip
            :: else -> assert(false) /* TFA_RING_BROKEN: no client of this model breaks it */
            fi
        :: else
        fi;
#ifdef SPIN_MODE
        goto start;
#else
        if
        :: goto start /* spins */
        :: skip       /* sleeps */
        fi;
#endif
#ifdef MUTATE_WORKER_FLAG_AFTER_RECHECK
        if
        :: WORK -> goto start
        :: else
        fi;
#endif
        if
        :: entry == ATTACHED -> d_step { assert(mapped); worker_asleep = 1 } /* A3 */
        :: else
        fi;
#ifdef MUTATE_WORKER_FLAG_CLEARED_EARLY
        worker_asleep = 0;
#endif
#if !defined(MUTATE_WORKER_NO_RECHECK) && !defined(MUTATE_WORKER_FLAG_AFTER_RECHECK)
        if
        :: entry == ATTACHED ->
            if
            :: request_seq[next_request % SLOTS] != BEFORE(next_request) -> goto awake /* R1 */
            :: else
            fi
        :: else
        fi;
#endif
#ifdef MUTATE_DOORBELL_READ_BEFORE_SLEEP
        doorbell = 0;
#endif
end_asleep:
        atomic { (doorbell || wake_event) -> doorbell = 0; wake_event = 0 }
awake:
        if
        :: entry == ATTACHED -> d_step { assert(mapped); worker_asleep = 0 } /* A3 */
        :: else
        fi;
        goto start
    } unless { atomic { kill_worker -> kill_worker = 0; slot = 0; scratch = 0; goto start } }
}

/* ---- the control thread ---- */

/* New segments are zero. */
inline map_segments()
{
    d_step {
        socket = ANSWERING;
#ifndef MUTATE_OLD_MEMORY_REUSED
        for (k : 0 .. SLOTS - 1) {
            request_seq[k] = 0; request_id[k] = 0; reply_seq[k] = 0; reply_id[k] = 0;
            request_writing[k] = 0; request_reading[k] = 0;
            reply_writing[k] = 0; reply_reading[k] = 0
        }
#endif
        k = 0;
        client_asleep = 0; worker_asleep = 0;
        next_request = 0; received = 0;
        doorbell = 0;
        mapped = 1
    }
}

active proctype Control()
{
    byte k;
start:
    {
        skip;
end_idle:
        do
        :: atomic { socket == HELLO && entry == FREE -> map_segments() };
            entry = ATTACHED; /* A6 */
#ifndef MUTATE_ATTACH_WITHOUT_WAKE
            wake_event = 1;
#endif
            d_step {
                if
                :: socket == ANSWERING -> socket = WELCOME
                :: else
                fi
            }
        :: hangup ->
            entry = DETACHING; /* A7 */
#ifndef MUTATE_DETACH_WITHOUT_WAKE
            wake_event = 1;
#endif
#ifndef MUTATE_ENTRY_FREED_EARLY
            (entry == DETACHED); /* R8 */
#endif
            mapped = 0;
            d_step { doorbell = 0; hangup = 0; entry = FREE }
        od
    } unless { atomic { kill_control -> kill_control = 0; k = 0; goto start } }
}

/* ---- crashes ---- */

active proctype Environment()
{
    byte clients, daemons;
    do
    :: clients < CLIENT_CRASHES && !kill_client -> d_step { clients++; kill_client = 1 }
    :: daemons < DAEMON_CRASHES -> d_step {
            daemons++;
            /* worker and control thread stop where they are; the kernel closes their descriptors */
            kill_worker = 1; kill_control = 1;
            entry = FREE; mapped = 0; next_request = 0;
            doorbell = 0; wake_event = 0; hangup = 0;
            if
            :: socket == ANSWERING -> socket = HELLO /* refused; the client tries again */
            :: socket == WELCOME -> hung_up = 1
            :: else
            fi
        }
    :: break
    od
}
