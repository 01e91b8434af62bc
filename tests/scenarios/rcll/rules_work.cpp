// How machines work: states, durations, what goes on while they are down, lights (red, yellow, green).

#include "rules_table.h"

namespace cxlab::rcll {

std::span<const Row> work_rows() {
  static const Row kRows[] = {
      {"states: of a base station",
       R"(C-BS is IDLE
        C-BS {side: OUTPUT, base_color: BASE_RED} -> 0 after 3.756
        feedback PROCESSING PROCESSED READY-AT-OUTPUT
        take C-BS-OUTPUT
        wait 0
        C-BS is WAIT-IDLE
        wait 4.8
        C-BS is WAIT-IDLE
        wait 0.3
        C-BS is IDLE)"},
      {"states: of a cap station that retrieves",
       R"(lay BASE_CLEAR CAP_BLACK at C-CS2-INPUT
        C-CS2 {operation: RETRIEVE_CAP} -> 0 after 21.694
        feedback PREPARED PROCESSING PROCESSED READY-AT-OUTPUT
        take C-CS2-OUTPUT
        wait 0
        C-CS2 is WAIT-IDLE
        wait 4.8
        C-CS2 is WAIT-IDLE
        wait 0.3
        C-CS2 is IDLE)"},
      {"states: of a delivery station",
       R"(lay BASE_RED CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0 after 3.746
        feedback PROCESSING PROCESSED
        wait 0
        C-DS is WAIT-IDLE
        wait 4.8
        C-DS is WAIT-IDLE
        wait 0.3
        C-DS is IDLE)"},
      {"states: READY-AT-OUTPUT lasts as long as the workpiece lies there",
       R"(C-BS {side: OUTPUT, base_color: BASE_RED} -> 0
        wait 200
        C-BS is READY-AT-OUTPUT)"},
      {"states: a base station that gives at its input waits there",
       R"(C-BS {side: INPUT, base_color: BASE_RED} -> 0
        wait 10
        C-BS is READY-AT-OUTPUT
        take C-BS-INPUT
        wait 0
        C-BS is WAIT-IDLE)"},
      {"states: BROKEN lasts 30 s",
       R"(C-CS1 {operation: RESET} -> 0
        C-CS1 is BROKEN
        wait 29.8
        C-CS1 is BROKEN
        wait 0.3
        C-CS1 is IDLE)"},

      {"durations: a base falls on the belt after 1.1 s",
       R"(C-BS {side: OUTPUT, base_color: BASE_RED}
        wait 1.06
        belt C-BS nothing
        wait 0.08
        belt C-BS BASE_RED)"},
      {"durations: a cap is taken off after 1.538 s of belt and 17.5 s",
       R"(lay BASE_CLEAR CAP_GREY at C-CS1-INPUT
        C-CS1 {operation: RETRIEVE_CAP}
        wait 1.48
        C-CS1 is PREPARED
        wait 0.1
        C-CS1 is PROCESSING
        wait 17.4
        belt C-CS1 BASE_CLEAR CAP_GREY
        C-CS1 is PROCESSING
        wait 0.12
        belt C-CS1 BASE_CLEAR
        C-CS1 is PROCESSED)"},
      {"durations: a cap is mounted in the same time",
       R"(lay BASE_CLEAR CAP_GREY at C-CS1-INPUT
        C-CS1 {operation: RETRIEVE_CAP} -> 0
        take C-CS1-OUTPUT
        wait 6
        lay BASE_RED at C-CS1-INPUT
        C-CS1 {operation: MOUNT_CAP} -> 0 after 21.694
        at C-CS1-OUTPUT BASE_RED CAP_GREY)"},
      {"durations: a ring is mounted after 1.538 s of belt and 17.308 s",
       R"(lay BASE_RED at C-RS1-INPUT
        C-RS1 {ring_color: RING_ORANGE}
        wait 1.48
        C-RS1 is PREPARED
        wait 0.1
        C-RS1 is PROCESSING
        wait 17.2
        belt C-RS1 BASE_RED
        wait 0.12
        belt C-RS1 BASE_RED RING_ORANGE
        C-RS1 is PROCESSED
        ends 0 after 21.502
        at C-RS1-OUTPUT BASE_RED RING_ORANGE)"},
      {"durations: storing takes 1.538 s of belt and 17.5 s",
       R"(lay BASE_RED CAP_GREY at C-SS-INPUT
        C-SS {operation: STORE, shelf: 2, slot: 2} -> 0 after 19.038
        feedback PREPARED PROCESSING PROCESSED)"},
      {"durations: bringing one out takes 17.5 s and 2.656 s of belt",
       R"(C-SS {operation: RETRIEVE, shelf: 0, slot: 1} -> 0 after 20.156
        feedback PROCESSING PROCESSED READY-AT-OUTPUT)"},
      {"durations: gate 1 takes 3.746 s",
       R"(order C0 BASE_RED CAP_GREY gate 1
        lay BASE_RED CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0 after 3.746)"},
      {"durations: gate 2 takes 4.746 s",
       R"(order C0 BASE_RED CAP_GREY gate 2
        lay BASE_RED CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0 after 4.746)"},
      {"durations: gate 3 takes 3.983 s",
       R"(order C0 BASE_RED CAP_GREY gate 3
        lay BASE_RED CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0 after 3.983)"},
      {"durations: what is discarded goes through gate 1",
       R"(order C0 BASE_RED CAP_GREY gate 2
        lay BASE_CLEAR at C-DS-INPUT
        C-DS {order_id: 0} -> 0 after 3.746)"},
      {"durations: a product that comes late to the delivery station takes as long from then on",
       R"(C-DS {order_id: 1}
        wait 10
        lay BASE_RED CAP_GREY at C-DS-INPUT
        ends 0 after 13.76)"},
      {"durations: a delivery takes its time, however long the product before was waited for",
       R"(order C0 BASE_RED CAP_GREY quantity 2
        C-DS {order_id: 1}
        wait 10
        lay BASE_RED CAP_GREY at C-DS-INPUT
        ends 0 after 13.76
        wait 6
        C-DS is IDLE
        lay BASE_RED CAP_GREY in C-DS
        C-DS {order_id: 1} -> 0 after 3.746)"},

      {"durations: a base takes as long when one lies at the output already",
       R"(lay BASE_BLACK at C-BS-OUTPUT
        C-BS {side: OUTPUT, base_color: BASE_RED} -> 0 in 3.76)"},
      {"durations: a cap takes as long when its workpiece lies in the middle and another at the output",
       R"(lay BASE_BLACK at C-CS1-OUTPUT
        lay BASE_RED CAP_GREY in C-CS1
        C-CS1 {operation: RETRIEVE_CAP} -> 0 in 21.7)"},
      {"durations: the gate takes its time from the arrival of the product that is there",
       R"(lay BASE_RED at C-DS-INPUT
        C-DS {order_id: 0}
        wait 3
        remove C-DS
        wait 2
        lay BASE_RED at C-DS-INPUT
        ends 0 in 8.8)"},
      {"down: an idle machine is idle again afterwards",
       R"(down C-RS1 30
        wait 0.02
        C-RS1 is DOWN
        wait 29.9
        C-RS1 is DOWN
        wait 0.2
        C-RS1 is IDLE)"},
      {"down: 50 s while PREPARED, and the cap is retrieved afterwards",
       R"(lay BASE_CLEAR CAP_GREY at C-CS1-INPUT
        C-CS1 {operation: RETRIEVE_CAP}
        wait 1
        down C-CS1 50
        wait 49.9
        C-CS1 is DOWN
        belt C-CS1 BASE_CLEAR CAP_GREY
        wait 0.16
        C-CS1 is PROCESSING
        ends 0 after 71.22)",
       kBox},
      {"down: 50 s while PREPARED, and the work takes 50 s longer",
       R"(lay BASE_CLEAR CAP_GREY at C-CS1-INPUT
        C-CS1 {operation: RETRIEVE_CAP}
        wait 1
        down C-CS1 50
        wait 1
        C-CS1 is DOWN
        ends 0 after 71.694)",
       kBook},
      {"down: 50 s while PROCESSING, the cap comes off meanwhile and counts afterwards",
       R"(lay BASE_CLEAR CAP_GREY at C-CS1-INPUT
        C-CS1 {operation: RETRIEVE_CAP}
        wait 12
        down C-CS1 50
        wait 6.9
        belt C-CS1 BASE_CLEAR CAP_GREY
        wait 0.3
        belt C-CS1 BASE_CLEAR
        wait 42.7
        C-CS1 is DOWN
        loaded C-CS1 0
        points
        wait 0.2
        C-CS1 is PROCESSED
        loaded C-CS1 1
        points buffer 2
        ends 0 after 64.72)",
       kBox},
      {"down: 50 s while PROCESSING, and the work takes 50 s longer",
       R"(lay BASE_CLEAR CAP_GREY at C-CS1-INPUT
        C-CS1 {operation: RETRIEVE_CAP}
        wait 12
        down C-CS1 50
        wait 49
        C-CS1 is DOWN
        wait 2
        C-CS1 is PROCESSING
        ends 0 after 71.694)",
       kBook},
      {"down: 50 s while PROCESSED, the belt runs on",
       R"(lay BASE_CLEAR CAP_GREY at C-CS1-INPUT
        C-CS1 {operation: RETRIEVE_CAP}
        wait 20
        C-CS1 is PROCESSED
        down C-CS1 50
        wait 3
        C-CS1 is DOWN
        at C-CS1-OUTPUT BASE_CLEAR
        ends 0 after 70.08)",
       kBox},
      {"down: 50 s while PROCESSED, and the belt takes 50 s longer",
       R"(lay BASE_CLEAR CAP_GREY at C-CS1-INPUT
        C-CS1 {operation: RETRIEVE_CAP}
        wait 20
        C-CS1 is PROCESSED
        down C-CS1 50
        wait 49
        C-CS1 is DOWN
        at C-CS1-OUTPUT nothing
        ends 0 after 71.694
        at C-CS1-OUTPUT BASE_CLEAR)",
       kBook},
      {"down: the 20 s after which a machine is stuck do not run",
       R"(C-CS1 {operation: RETRIEVE_CAP}
        wait 15
        down C-CS1 30
        wait 34
        C-CS1 is PREPARED
        wait 1.2
        C-CS1 is BROKEN)"},
      {"down: what lies at the output can be taken",
       R"(C-BS {side: OUTPUT, base_color: BASE_RED} -> 0
        down C-BS 30
        wait 1
        take C-BS-OUTPUT
        C-BS is DOWN
        wait 30
        C-BS is WAIT-IDLE)"},

      {"down: WAIT-IDLE goes on meanwhile, and is seen once more",
       R"(C-BS {side: OUTPUT, base_color: BASE_RED} -> 0
        take C-BS-OUTPUT
        wait 1
        C-BS is WAIT-IDLE
        down C-BS 10
        wait 9.98
        C-BS is DOWN
        wait 0
        C-BS is WAIT-IDLE
        wait 0
        C-BS is IDLE)"},
      {"down: a down time within WAIT-IDLE does not make it longer",
       R"(C-BS {side: OUTPUT, base_color: BASE_RED} -> 0
        take C-BS-OUTPUT
        wait 1
        down C-BS 2
        wait 3.7
        C-BS is WAIT-IDLE
        wait 0.5
        C-BS is IDLE)"},
      {"down: hides BROKEN, whose 30 s go on",
       R"(C-BS {operation: RESET} -> 0
        wait 1
        down C-BS 10
        wait 1
        C-BS is DOWN
        wait 9.1
        C-BS is BROKEN
        wait 18.5
        C-BS is BROKEN
        wait 0.5
        C-BS is IDLE)"},
      {"down: a BROKEN machine is IDLE when the down time ends later, after BROKEN was seen once",
       R"(C-BS {operation: RESET} -> 0
        wait 1
        down C-BS 40
        wait 39.98
        C-BS is DOWN
        wait 0
        C-BS is BROKEN
        wait 0
        C-BS is IDLE)"},
      {"down: a reset meanwhile is seen afterwards",
       R"(hold BASE_RED
        put C-RS1-SLIDE
        wait 0.04
        down C-RS1 40
        wait 5
        C-RS1 {operation: RESET} -> 0
        C-RS1 is DOWN
        points
        C-RS1 {operation: RESET} -> 209
        wait 34
        C-RS1 is DOWN
        wait 1.2
        C-RS1 is IDLE
        loaded C-RS1 0)"},
      {"lights: IDLE", "lights C-BS OFF OFF ON"},
      {"lights: PREPARED",
       R"(C-CS1 {operation: RETRIEVE_CAP}
        wait 1
        lights C-CS1 OFF OFF BLINK)"},
      {"lights: PROCESSING",
       R"(C-BS {side: OUTPUT, base_color: BASE_RED}
        wait 0.5
        C-BS is PROCESSING
        lights C-BS OFF ON ON)"},
      {"lights: PROCESSED",
       R"(C-BS {side: OUTPUT, base_color: BASE_RED}
        wait 2
        C-BS is PROCESSED
        lights C-BS OFF ON ON)"},
      {"lights: READY-AT-OUTPUT",
       R"(C-BS {side: OUTPUT, base_color: BASE_RED} -> 0
        lights C-BS OFF ON BLINK)"},
      {"lights: WAIT-IDLE",
       R"(C-BS {side: OUTPUT, base_color: BASE_RED} -> 0
        take C-BS-OUTPUT
        wait 0
        lights C-BS OFF BLINK BLINK)"},
      {"lights: BROKEN",
       R"(C-BS {operation: RESET} -> 0
        wait 0
        lights C-BS BLINK BLINK OFF)"},
      {"lights: DOWN",
       R"(down C-BS 30
        wait 1
        lights C-BS ON OFF OFF)"},
      {"lights: all are on during set-up",
       R"(setup 10
        lights C-BS ON ON ON
        lights M-RS2 ON ON ON
        until 10.1
        lights C-BS OFF OFF ON)"},
      {"lights: red blinks when the game is over",
       R"(production 10
        overtime 0
        C-CS1 {operation: RETRIEVE_CAP}
        until 10.1
        lights C-BS BLINK OFF OFF
        lights C-CS1 BLINK OFF OFF)"},

  };
  return kRows;
}

}  // namespace cxlab::rcll
