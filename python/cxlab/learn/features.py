"""The features of choices, in order: those of the rule agent (scenarios/rcll/agent/clips/external.clp), and those of the planning
agent (scenarios/rcll/planning_agent/clips/dispatch/external.clp), which asks for steps."""

from __future__ import annotations

KINDS = ("begin-order", "take-job", "begin-step")

_OF_RULES = ("time", "idle", "waiting", "products", "open_orders", "caps", "payments_missing", "machines_down")

SITUATION = {"begin-order": _OF_RULES, "take-job": _OF_RULES, "begin-step": ("time", "idle", "running", "not_begun")}

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
    "begin-step": (
        "preferred", "wait", "begin", "duration", "way", "fetch-carrier", "bring-base", "transport", "bring-to-delivery",
        "pay-with-new-base", "pay-with-bare-base", "held_back",
    ),
}  # fmt: skip
