"""The features of the choices of the rule agent (scenarios/rcll/agent/clips/external.clp), in order."""

from __future__ import annotations

SITUATION = ("time", "idle", "waiting", "products", "open_orders", "caps", "payments_missing", "machines_down")

KINDS = ("begin-order", "take-job")

OPTION = {
    "begin-order": (
        "preferred", "none", "worth", "points", "jobs", "rings", "payments", "to_begin", "to_end", "game_left", "bonus",
        "first_machine_shared", "machines_shared", "cap_ready", "spare_robots",
    ),
    "take-job": (
        "preferred", "wait", "urgency", "way", "haul", "detour", "buffer", "clear", "pay", "to_ring_station", "to_cap_station",
        "deliver", "not_there_yet", "not_free_yet", "base_taken", "payments_missing", "points", "time_left", "works_left",
        "users", "next_users",
    ),
}  # fmt: skip
