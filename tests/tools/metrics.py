# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Statistics as text for Prometheus: every line has the form, every metric stands once with help and
type, histograms are cumulative, and the figures are those of the snapshot. Figures of a running daemon:
http_server.py.

    metrics.py BIN ROBOTS
"""
import json
import math
import pathlib
import re
import sys
import unittest

import totalforce as tf
from totalforce_tools import web_metrics

SAMPLE = re.compile(r'(\w+)(\{\w+="(?:[^"\\\n]|\\[\\"n])*"(?:,\w+="(?:[^"\\\n]|\\[\\"n])*")*\})? '
                    r"(NaN|[+-]Inf|-?[0-9][0-9.e+-]*)")
TALLY = dict.fromkeys(("requests", "rejected", "late", "states", "busy_ns", "refined", "estimates",
                       "fallbacks", "inaccurate", "stalled", "not_finite", "residual_precision",
                       "sentinel"), 0)
DDS = web_metrics.DDS + web_metrics.ENDPOINTS
TIMES = (127, 128, 2**64 - 1)
CONFIG = pathlib.Path(sys.argv[2]).parent


def snapshot(**robot):
    """One robot, as totalforce.Statistics.read gives it"""
    times = {name: tf.Histogram(TIMES) for name in ("queue", "compute", "total")}
    tally = {**TALLY, "largest_estimate": math.inf, "requests": 33, "busy_ns": 10**18 + 1,
             "methods": {"aba": 29, "unknown": 1}, "statuses": {"OK": 30, "E_VALUE": 3}, **times}
    inputs = [{"name": name, "publishers": 1, "received": 2, "refused": 3, "oversized": 4,
               "last": last} for name, last in (("/joint_states", 0), ("/odom", 3))]
    served = {"name": 'a"b\\c\nd', "model_hash": "00ff", "kernel_isa": "avx2", "kernel_file": "",
              "precision": "f64", "joints": 7, "clients": 1, "queued": 2, "total": tally,
              "inputs": inputs}
    return {"version": "1.0", "time": 5 * 10**9 + 5, "start": 5, "connections": 4, "refused": 1,
            "reloads": 0, "dds": dict.fromkeys(DDS, 0), "clients": [], "robots": [served | robot]}


def parse(text):
    """{line up to its value: value} of samples; fails where a line has not the form"""
    found, families, family, kind = {}, set(), None, None
    for line in text.splitlines():
        word = line.split()
        if line.startswith("# HELP "):
            assert word[2] not in families and len(word) > 3, line
            families.add(family := word[2])
            kind = None
        elif line.startswith("# TYPE "):
            assert word[2] == family and word[3] in ("counter", "gauge", "histogram"), line
            kind = word[3]
            assert kind != "counter" or family.endswith("_total"), line
        else:
            match = SAMPLE.fullmatch(line)
            assert match and kind, line
            tails = ("_bucket", "_sum", "_count") if kind == "histogram" else ("",)
            assert match[1] in [family + tail for tail in tails], line
            key = match[1] + (match[2] or "")
            assert key not in found, line
            found[key] = float(match[3])
    return found


ROBOT = r'robot="a\"b\\c\nd"'


class Text(unittest.TestCase):
    def test_figures(self):
        text = web_metrics.text(snapshot())
        self.assertTrue(text.endswith("\n"))
        found = parse(text)
        for key, number in (
                (f"requests_total{{{ROBOT}}}", 33), (f"clients{{{ROBOT}}}", 1),
                (f'answers_total{{{ROBOT},method="aba"}}', 29),
                (f'answers_total{{{ROBOT},method="unknown"}}', 1),
                (f'failures_total{{{ROBOT},status="E_VALUE"}}', 3),
                (f"queued_requests{{{ROBOT}}}", 2), (f"busy_seconds_total{{{ROBOT}}}", 1e9),
                (f"largest_error_estimate{{{ROBOT}}}", math.inf),
                (f'input_refusals_total{{{ROBOT},topic="/odom"}}', 7),
                (f'input_age_seconds{{{ROBOT},topic="/odom"}}', 5.000000002),
                ("uptime_seconds", 5), ("connections_total", 4), ('build_info{version="1.0"}', 1),
                ('dds_endpoints{kind="reply_readers"}', 0), ('dds_messages_total{kind="late"}', 0)):
            self.assertEqual(found[f"totalforce_{key}"], number, key)
        age = found[f'totalforce_input_age_seconds{{{ROBOT},topic="/joint_states"}}']
        self.assertTrue(math.isnan(age))
        self.assertFalse(any('status="OK"' in key for key in found))
        self.assertIn('model="00ff",isa="avx2",kernel="generic",precision="f64",joints="7"', text)

    def test_histograms(self):
        """Bounds grow, counts do not fall, the last is the count."""
        found = parse(web_metrics.text(snapshot()))
        for name in ("queue_seconds", "compute_seconds", "latency_seconds"):
            start = f'totalforce_{name}_bucket{{{ROBOT},le="'
            buckets = [(key[len(start):-2], value) for key, value in found.items()
                       if key.startswith(start)]
            bounds = [float(bound) for bound, _ in buckets]
            counts = [count for _, count in buckets]
            self.assertEqual(bounds, sorted(set(bounds)))
            self.assertEqual(counts, sorted(counts))
            self.assertGreater(len(buckets), 20)
            self.assertEqual(buckets[0], ("1.27e-07", 1))
            self.assertEqual(buckets[1], ("2.55e-07", 2))
            self.assertEqual(buckets[-1], ("+Inf", 3))
            self.assertEqual(found[f"totalforce_{name}_count{{{ROBOT}}}"], 3)

    def test_dashboard_and_alerts(self):
        """Every name in them is served."""
        served = {key.split("{")[0] for key in parse(web_metrics.text(snapshot()))}
        for name in ("dashboard.json", "alerts.yaml"):
            text = (CONFIG / "metrics" / name).read_text(encoding="utf-8")
            asked = set(re.findall(r"totalforce_[a-z0-9_]+", text))
            self.assertGreater(len(asked), 7)
            self.assertFalse(asked - served, name)
        for panel in json.loads((CONFIG / "metrics/dashboard.json").read_text())["panels"]:
            self.assertTrue(all(re.search("totalforce_", t["expr"]) for t in panel["targets"]))

    def test_without(self):
        """Neither DDS nor ROS 2: no such samples."""
        found = parse(web_metrics.text({**snapshot(inputs=[]), "dds": None}))
        self.assertFalse([key for key in found if "dds" in key or "input" in key])


unittest.main(argv=["metrics"])
