# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Figures as JSON and as the table of a page without scripts."""
import html
import json
import math
import pathlib
import secrets
import time

import numpy as np
import totalforce as tf
from totalforce_tools.web_daemon import Gone, client_key

PAGE = pathlib.Path(__file__).with_name("web.html")
TALLY = ("requests", "rejected", "late", "states", "fallbacks", "estimates", "refined",
         "inaccurate", "not_finite", "sentinel", "largest_estimate", "methods")
DDS = ("request_writers", "reply_readers", "torque_writers", "acceleration_readers", "rejected")


def rounded(value):
    """Numbers with six digits, null where they are not finite; arrays as lists."""
    if isinstance(value, np.ndarray):
        return rounded(value.tolist())
    if isinstance(value, float):
        return float(f"{value:.6g}") if math.isfinite(value) else None
    if isinstance(value, dict):
        return {key: rounded(entry) for key, entry in value.items()}
    return [rounded(entry) for entry in value] if isinstance(value, (list, tuple)) else value


def json_text(value):
    """JSON that means nothing as HTML."""
    text = json.dumps(rounded(value), separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e")


def age(now, then):
    """ms; None: never"""
    return 1e-6 * max(now - then, 0) if then else None


# Model and motion

async def model(daemon, index):
    robot = daemon.snapshot()["robots"][index]
    figure, _ = await daemon.figure(index)
    links = figure and {"frames": figure.model.links, "parents": figure.parents,
                        "joints": figure.model.joint_names}
    return {"robot": robot["name"], "model": figure and figure.model.hash,
            **(links or {"frames": [], "parents": [], "joints": []})}


async def motion(daemon, index):
    figure, error = await daemon.figure(index)
    robot = daemon.snapshot()["robots"][index]
    state = robot["state"]
    if figure and figure.drawn_at != daemon.read:
        figure.drawn_at, figure.drawn = daemon.read, figure.motion(state)
    drawn = figure.drawn if figure else {"error": error}
    return {"robot": robot["name"], "model": figure and figure.model.hash,
            "age_ms": age(time.monotonic_ns(), state["time"] if state else 0), **drawn}


# The state

def refusals(tally):
    return [{"count": count, "name": name, **dict(zip(("text", "cause"), tf.STATUSES[name]))}
            for name, count in tally["statuses"].items() if name != "OK"]


def inputs(robot, now):
    topics = [{"publishers": i["publishers"], "topic": i["name"], "received": i["received"],
               "refused": i["refused"] + i["oversized"], "age_ms": age(now, i["last"])}
              for i in robot["inputs"]]
    return {"inputs": topics, "dds_request_age_ms": age(now, robot["dds_request"]),
            "dds_torques_age_ms": age(now, robot["dds_torques"]),
            **{name: robot[name] for name in ("ros2_refused", "ros2_refusal", "ros2_subscribers")}}


def client(c, now, rate):
    times = c["tally"]["compute"]
    shown = {name: c[name] for name in ("process", "user", "worker", "kind", "queued")}
    shown |= {name: c["tally"][name] for name in ("requests", "rejected")}
    shown |= {"seconds": 1e-9 * (now - c["since"]), "p50_us": 1e-3 * times.quantile(0.5),
              "p99_us": 1e-3 * times.quantile(0.99)}
    return shown if rate is None else shown | {"rate": rate}


def clients(daemon, index):
    s = daemon.snapshot()
    return [client(c, s["time"], daemon.rates.get(client_key(c))) for c in s["clients"]
            if c["robot"] == index and c["kind"] != "self-test"]


def served(robot):
    return {"robot": robot["name"], "model": robot["model_hash"], "isa": robot["kernel_isa"],
            "kernel": robot["kernel_file"], "precision": robot["precision"],
            "joints": robot["joints"], "freedoms": robot["freedoms"] + robot["base_freedoms"],
            "dds": robot["dds"], "ros2": robot["ros2_namespace"] if robot["ros2_node"] else "",
            "ros2_node": robot["ros2_node"], "queued": robot["queued"]}


def of_daemon(s):
    return {"process": s["process"], "robots": [r["name"] for r in s["robots"]],
            "version": s["version"], "uptime_s": 1e-9 * (s["time"] - s["start"]),
            "workers": s["worker_count"], "reloads": s["reloads"],
            "connections": s["connections"], "connections_refused": s["refused"],
            **{f"dds_{name}": s["dds"][name] for name in DDS if s["dds"]}}


async def state(daemon, index):
    drawn = await motion(daemon, index)
    s = daemon.snapshot()
    robot = s["robots"][index]
    return {**of_daemon(s), **served(robot), **{name: robot["total"][name] for name in TALLY},
            "refusals": refusals(robot["total"]), "second": daemon.seconds,
            "history": list(daemon.history[index]), **inputs(robot, s["time"]),
            "clients": clients(daemon, index), "motion": drawn}


# The page

def table_row(robot, last):
    """A robot in the table; `last`: its last second, None: there is none yet."""
    numbers = [f"{last[k]:.4g}" if last and last[k] is not None else "-" for k in (0, 7, 8)]
    numbers = [robot["clients"], *numbers,
               *(robot["total"][name] for name in ("requests", "rejected", "fallbacks"))]
    cells = "".join(f"<td class=n>{number}</td>" for number in numbers)
    return f"<tr><th scope=row>{html.escape(robot['name'])}</th>{cells}</tr>\n"


def table(daemon):
    """The numbers of the moment: all of a page without scripts."""
    s = daemon.snapshot()
    heads = ("Clients", "Requests/s", "Median, &micro;s", "99 %, &micro;s", "Requests", "Refused",
             "Fallbacks")
    titles = "".join(f"<th class=n>{head}</th>" for head in heads)
    rows = "".join(table_row(robot, rows[-1] if rows else None)
                   for robot, rows in zip(s["robots"], daemon.history))
    return (f"<p>totalforced {html.escape(s['version'])}, process {s['process']}, up for "
            f"{1e-9 * (s['time'] - s['start']):.0f} s, workers: {s['worker_count']}</p>\n"
            f"<div class=scroll><table><thead><tr><th>Robot</th>{titles}</tr></thead><tbody>\n"
            f"{rows}</tbody></table></div>\n")


def page(daemon):
    """(text, nonce) of the page"""
    nonce = secrets.token_hex(16)
    text = PAGE.read_text(encoding="utf-8").replace("@NONCE@", nonce)
    try:
        content = table(daemon)
    except Gone as reason:
        content = f"<p class=note>{html.escape(str(reason))}</p>\n"
    return text.replace("@TABLE@", content), nonce
