# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Statistics as text for Prometheus (exposition format 0.0.4). All lines of one metric stand
together, after its HELP and TYPE."""
import math

CONTENT_TYPE = "text/plain; version=0.0.4; charset=utf-8"
NS = 1e-9
# of the histograms' buckets, ns: tops of buckets of the statistics
BOUNDS = [2**k - 1 for k in range(7, 36)]
DDS = ("requests", "torques", "replies", "rejected", "late", "unknown", "dropped", "standby",
       "handovers")
ENDPOINTS = ("request_writers", "reply_readers", "torque_writers", "acceleration_readers")


# Samples of a snapshot: (suffix of the name, labels, value)

def once(of, **labels):
    return lambda s: [("", labels, of(s))]


def by_robot(of, labels=lambda r: {}):
    return lambda s: [("", {"robot": r["name"], **labels(r)}, of(r)) for r in s["robots"]]


def tally(member):
    return by_robot(lambda r: r["total"][member])


def by_word(label, member):
    return lambda s: [("", {"robot": r["name"], label: word}, count) for r in s["robots"]
                      for word, count in r["total"][member].items() if word != "OK"]


def by_input(of):
    return lambda s: [("", {"robot": r["name"], "topic": i["name"]}, of(s, i))
                      for r in s["robots"] for i in r["inputs"]]


def of_dds(members):
    return lambda s: [("", {"kind": member}, s["dds"][member]) for member in members]


def histogram(member):
    return lambda s: [sample for r in s["robots"] for sample in of_times(r, r["total"][member])]


def of_times(robot, times):
    labels, below, tops = {"robot": robot["name"]}, times.buckets.cumsum(), times.tops
    for bound in BOUNDS:
        count = below[tops.searchsorted(bound, "right") - 1]
        yield "_bucket", {**labels, "le": f"{NS * bound:.12g}"}, int(count)
    yield "_bucket", {**labels, "le": "+Inf"}, times.count
    yield "_sum", labels, NS * times.sum
    yield "_count", labels, times.count


# (name, help, samples): a counter if the name ends so, a histogram of seconds, else a gauge
METRICS = [
    ("build_info", "Version of the daemon; always 1.",
     lambda s: once(lambda _: 1, version=s["version"])(s)),
    ("uptime_seconds", "Time since the start of the daemon.",
     once(lambda s: NS * (s["time"] - s["start"]))),
    ("connections_total", "Connections of clients to sockets.", once(lambda s: s["connections"])),
    ("refused_connections_total", "Connections that were refused.", once(lambda s: s["refused"])),
    ("reloads_total", "Reloads that exchanged a model.", once(lambda s: s["reloads"])),
    ("robot_info", "Model and kernel of each robot; always 1.", by_robot(lambda r: 1, lambda r: {
        "model": r["model_hash"], "isa": r["kernel_isa"],
        "kernel": "specialised" if r["kernel_file"] else "generic", "precision": r["precision"],
        "joints": r["joints"]})),
    ("requests_total", "Requests answered, with whatever status.", tally("requests")),
    ("deadline_misses_total", "Requests refused because their deadline had passed.",
     tally("late")),
    ("states_total", "States of requests with answers.", tally("states")),
    ("refined_states_total", "States of requests that asked for refinement.", tally("refined")),
    ("error_estimates_total", "States whose error was estimated.", tally("estimates")),
    ("fallbacks_total", "States that another method answered than asked.", tally("fallbacks")),
    ("inaccurate_total", "States whose error estimate was above 1e-4.", tally("inaccurate")),
    ("stalled_refinements_total", "States whose refinement stalled.", tally("stalled")),
    ("residual_precision_total", "States computed in higher precision.",
     tally("residual_precision")),
    ("sentinel_trips_total", "States whose sentinel tripped.", tally("sentinel")),
    ("busy_seconds_total", "Time spent on requests.",
     by_robot(lambda r: NS * r["total"]["busy_ns"])),
    ("clients", "Connections of other processes, without gateways.",
     by_robot(lambda r: r["clients"])),
    ("queued_requests", "Requests that wait in rings.", by_robot(lambda r: r["queued"])),
    ("largest_error_estimate", "Largest error estimate since the start.",
     tally("largest_estimate")),
    ("answers_total", "Requests with answers, by method of the first state.",
     by_word("method", "methods")),
    ("failures_total", "Requests with a status other than ok, by status.",
     by_word("status", "statuses")),
    ("queue_seconds", "Time from receipt of a request to its start.", histogram("queue")),
    ("compute_seconds", "Time from the start of a request to its answer.", histogram("compute")),
    ("latency_seconds", "Time from the client's sending to the answer, where the client says when.",
     histogram("total")),
    ("input_age_seconds", "Time since the last message; NaN: none.",
     by_input(lambda s, i: NS * (s["time"] - i["last"]) if i["last"] else math.nan)),
    ("input_messages_total", "Messages of ROS 2.", by_input(lambda _, i: i["received"])),
    ("input_refusals_total", "Messages of ROS 2 that could not be used.",
     by_input(lambda _, i: i["refused"] + i["oversized"])),
    ("input_publishers", "Matched publishers.", by_input(lambda _, i: i["publishers"])),
    ("dds_messages_total", "Messages of the DDS gateway, by outcome.", of_dds(DDS)),
    ("dds_endpoints", "Matched endpoints of others on DDS.", of_dds(ENDPOINTS)),
]
HISTOGRAMS = ("queue_seconds", "compute_seconds", "latency_seconds")


def quoted(text):
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n") + '"'


def value(number):
    """As the format spells it."""
    if isinstance(number, int):
        return str(number)
    if math.isnan(number):
        return "NaN"
    return f"{number:.12g}" if math.isfinite(number) else "+Inf" if number > 0 else "-Inf"


def lines(s):
    for name, what, samples in METRICS:
        if name.startswith("dds_") and not s["dds"]:
            continue
        kind = ("counter" if name.endswith("_total") else
                "histogram" if name in HISTOGRAMS else "gauge")
        yield f"# HELP totalforce_{name} {what}"
        yield f"# TYPE totalforce_{name} {kind}"
        for suffix, labels, number in samples(s):
            pairs = ",".join(f"{key}={quoted(str(label))}" for key, label in labels.items())
            braces = f"{{{pairs}}}" if pairs else ""
            yield f"totalforce_{name}{suffix}{braces} {value(number)}"


def text(s):
    """The text of a snapshot (totalforce.Statistics.read)."""
    return "".join(f"{line}\n" for line in lines(s))
