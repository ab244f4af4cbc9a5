# SPDX-License-Identifier: Apache-2.0
"""A procedure of minutes instead of days, for tests that run whole campaigns."""
import json


def short_procedure(set_points=(15, 30), runs=1, positions=("+Z", "-Z"), preflight_s=0, dwell_s=30, purpose="calibration",
                    extra=""):
    return f"""name = "short"
purpose = "{purpose}"
kind = "soak"
runs = {runs}
[temperatures]
list_c = {list(set_points)}
[positions]
order = {json.dumps(list(positions))}
dwell_s = {dwell_s}
[stability]
slope_kpmin = 0.05
confidence = 0.95
window_s = 180
min_window_s = 60
minimum_soak_s = 60
after_turn_s = 15
timeout_s = 200000
[units]
rate_hz = 10
temp_rate_hz = 2
[power]
off_s = 10
[preflight]
position_s = {preflight_s}
{extra}"""
