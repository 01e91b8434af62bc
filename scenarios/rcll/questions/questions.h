#pragma once
// What can be asked about a recorded game (docs/reference/game-questions.md). Each reads a GameStory and fills tables.

#include "scenarios/question.h"

namespace cxlab::rcll {

Expected<WorldAnswer> answer_orders(const AskedRun& run);
Expected<WorldAnswer> answer_waits(const AskedRun& run);
Expected<WorldAnswer> answer_machines(const AskedRun& run);
Expected<WorldAnswer> answer_pieces(const AskedRun& run);

inline constexpr WorldQuestion kQuestions[]{
    {.name = "orders",
     .what = "List the orders of a game: when robots worked for them, and why a product is late or missing",
     .argument = "order",
     .argument_help = "Only the order with this number (default: all)",
     .examples = "  cxlab orders runs/game-1\n  cxlab orders runs/game-1 3\n  cxlab orders runs/game-1 --at 8:30",
     .ask = answer_orders},
    {.name = "waits",
     .what = "List what the robots of a game waited for, when and how long",
     .argument = "robot",
     .argument_help = "Only this robot (default: all)",
     .examples = "  cxlab waits runs/game-1 --sort length_s\n  cxlab waits runs/game-1 robot2 --from 5:00 --to 8:00",
     .ask = answer_waits},
    {.name = "machines",
     .what = "List what the machines of a game did: share of time in each state, works, failures, queues",
     .argument = "machine",
     .argument_help = "Only this machine (default: those of the teams that play)",
     .examples = "  cxlab machines runs/game-1\n  cxlab machines runs/game-1 C-RS1 --from 5:00",
     .ask = answer_machines},
    {.name = "pieces",
     .what = "List the workpieces of a game: where each came from, what was done to it, where it ended",
     .argument = "piece",
     .argument_help = "Only the workpiece with this number (default: all)",
     .examples = "  cxlab pieces runs/game-1\n  cxlab pieces runs/game-1 13",
     .ask = answer_pieces},
};

}  // namespace cxlab::rcll
