// What breaks a machine, and what that costs.

#include "rules_table.h"

namespace cxlab::rcll {

std::span<const Row> breaking_rows() {
  static const Row kRows[] = {
      {"breaking: what lies on other machines stays there",
       R"(lay BASE_RED at C-CS1-INPUT
        lay BASE_BLACK at C-BS-OUTPUT
        C-BS {operation: RESET} -> 0
        at C-CS1-INPUT BASE_RED
        at C-BS-OUTPUT nothing)"},

      {"breaking: its own team resets it",
       R"(C-BS {side: OUTPUT, base_color: BASE_RED}
        wait 2
        belt C-BS BASE_RED
        C-BS {operation: RESET} -> 0
        C-BS is BROKEN
        belt C-BS nothing
        C-BS {operation: RESET} -> 209
        wait 30.1
        C-BS is IDLE)"},
      {"breaking: the instruction that it carried out ends with code 1",
       R"(C-BS {side: OUTPUT, base_color: BASE_RED}
        wait 2
        C-BS {operation: RESET} -> 0
        before ends 1)"},
      {"breaking: no workpiece within 20 s of PREPARED",
       R"(C-CS1 {operation: RETRIEVE_CAP} -> 202 after 20.04
        C-CS1 is BROKEN)"},
      {"breaking: a workpiece that comes after 19 s is in time",
       R"(C-CS1 {operation: RETRIEVE_CAP}
        wait 18
        lay BASE_CLEAR CAP_GREY at C-CS1-INPUT
        wait 1.7
        C-CS1 is PROCESSING)"},
      {"breaking: a workpiece is lost while PROCESSING",
       R"(lay BASE_CLEAR CAP_GREY at C-CS1-INPUT
        C-CS1 {operation: RETRIEVE_CAP}
        wait 5
        remove C-CS1
        ends 202 after 21.58
        C-CS1 is BROKEN)"},
      {"breaking: a workpiece is lost while PROCESSED",
       R"(C-BS {side: OUTPUT, base_color: BASE_RED}
        wait 2
        C-BS is PROCESSED
        remove C-BS
        ends 202 after 21.14
        C-BS is BROKEN)"},
      {"breaking: a base station whose belt is not free for 20 s",
       R"(lay BASE_BLACK in C-BS
        C-BS {side: OUTPUT, base_color: BASE_RED} -> 202 after 20.04
        C-BS is BROKEN
        belt C-BS nothing)"},
      {"breaking: nothing comes to a delivery station that has begun",
       R"(C-DS {order_id: 1} -> 202 after 20.06
        C-DS is BROKEN
        verdict none)"},
      {"breaking: unused payments are taken back, 2 each",
       R"(hold BASE_RED
        put C-RS1-SLIDE
        hold BASE_RED
        put C-RS1-SLIDE
        hold BASE_RED
        put C-RS2-SLIDE
        wait 0.04
        points payment 6
        C-RS1 {operation: RESET} -> 0
        wait 0
        points payment 2
        loaded C-RS1 2
        wait 30.2
        loaded C-RS1 0
        loaded C-RS2 1
        wait 31
        C-RS1 is IDLE
        loaded C-RS1 0)"},
      {"breaking: a base on the slide of a station that is BROKEN and DOWN is paid and not taken back",
       R"(hold BASE_RED
        put C-RS1-SLIDE
        wait 0.04
        break C-RS1
        wait 0.04
        points
        hold BASE_BLACK
        put C-RS1-SLIDE
        wait 0.04
        points
        down C-RS1 20
        hold BASE_SILVER
        wait 1
        C-RS1 is DOWN
        put C-RS1-SLIDE
        wait 0.04
        given payment 2 payment -2 payment 2
        wait 20
        C-RS1 is BROKEN
        hold BASE_SILVER
        put C-RS1-SLIDE
        wait 10
        C-RS1 is IDLE
        loaded C-RS1 0
        points payment 2)",
       kBox},
      {"breaking: a base for which a slide that is BROKEN and DOWN has no room counts nothing",
       R"(hold BASE_RED
        put C-RS2-SLIDE
        hold BASE_RED
        put C-RS2-SLIDE
        hold BASE_RED
        put C-RS2-SLIDE
        wait 0.04
        break C-RS2
        down C-RS2 10
        wait 1
        hold BASE_RED
        put C-RS2-SLIDE
        wait 0.04
        given payment 2 payment 2 payment 2 payment -6
        C-RS2 is DOWN)",
       kBox},
      {"breaking: a base on the slide of a station that is BROKEN and DOWN counts nothing",
       R"(break C-RS1
        down C-RS1 20
        hold BASE_SILVER
        wait 1
        C-RS1 is DOWN
        put C-RS1-SLIDE
        wait 35
        loaded C-RS1 0
        points)",
       kBook},
      {"breaking: a cap station that is BROKEN and DOWN keeps nothing, and its shelf is filled",
       R"(lay BASE_CLEAR CAP_GREY at C-CS1-INPUT
        C-CS1 {operation: RETRIEVE_CAP} -> 0
        break C-CS1
        down C-CS1 40
        take C-CS1-SHELF-LEFT
        drop
        take C-CS1-SHELF-MIDDLE
        drop
        take C-CS1-SHELF-RIGHT
        drop
        wait 25
        C-CS1 is DOWN
        at C-CS1-SHELF-LEFT BASE_CLEAR CAP_GREY
        C-CS1 {operation: MOUNT_CAP} -> 209
        C-CS1 {operation: RESET} -> 209
        wait 16
        C-CS1 is IDLE
        C-CS1 {operation: MOUNT_CAP} -> 103)",
       kBox},
      {"breaking: an unpaid ring at once; the second time it waits for payments and works",
       R"(lay BASE_RED at C-RS1-INPUT
        C-RS1 {ring_color: RING_GREEN} -> 103
        C-RS1 is BROKEN
        wait 31
        lay BASE_RED at C-RS1-INPUT
        C-RS1 {ring_color: RING_GREEN}
        wait 5
        C-RS1 is PREPARED
        at C-RS1-INPUT BASE_RED
        lights C-RS1 OFF OFF BLINK
        hold BASE_BLACK
        put C-RS1-SLIDE
        wait 5
        C-RS1 is PREPARED
        at C-RS1-INPUT BASE_RED
        hold BASE_BLACK
        put C-RS1-SLIDE
        wait 2
        C-RS1 is PROCESSING
        loaded C-RS1 0
        ends 0
        at C-RS1-OUTPUT BASE_RED RING_GREEN
        points payment 4)",
       kBox},
      {"breaking: an unpaid ring; the second time after 20 s, each time",
       R"(C-RS2 {ring_color: RING_BLUE} -> 103
        wait 31
        C-RS2 {ring_color: RING_BLUE} -> 103 after 20.04
        C-RS2 is BROKEN
        told {"event": "broken", "reason": "stuck for 20 s in PREPARED: RING_BLUE costs 1 payments, 0 lie on the slide"}
        wait 31
        C-RS2 {ring_color: RING_BLUE} -> 103 after 20.04
        points)",
       kBox},
      {"breaking: an unpaid ring with other counts than the last time at once",
       R"(C-RS1 {ring_color: RING_GREEN} -> 103
        wait 31
        hold BASE_BLACK
        put C-RS1-SLIDE
        wait 1
        C-RS1 {ring_color: RING_GREEN} -> 103 after 0.04
        wait 31
        C-RS1 {ring_color: RING_GREEN} -> 103 after 0.04
        wait 31
        C-RS1 {ring_color: RING_GREEN} -> 103 after 20.04
        given payment 2 payment -2)",
       kBox},
      {"breaking: what a second unpaid instruction was paid is taken back",
       R"(C-RS1 {ring_color: RING_GREEN} -> 103
        wait 31
        C-RS1 {ring_color: RING_GREEN}
        hold BASE_BLACK
        put C-RS1-SLIDE
        ends 103
        given payment 2 payment -2)",
       kBox},
      {"breaking: an unpaid ring each time at once",
       R"(C-RS1 {ring_color: RING_GREEN} -> 103
        wait 31
        C-RS1 {ring_color: RING_GREEN} -> 103 after 0.04
        C-RS1 is BROKEN)",
       kBook},
      {"breaking: other senseless instructions each time at once",
       R"(C-CS1 {operation: MOUNT_CAP} -> 103
        C-SS {operation: RETRIEVE, shelf: 0, slot: 0} -> 103
        C-DS {order_id: 99} -> 103
        C-BS {side: OUTPUT} -> 103
        C-RS1 {ring_color: RING_BLUE} -> 103
        wait 31
        C-CS1 {operation: MOUNT_CAP} -> 103 after 0.04
        C-SS {operation: RETRIEVE, shelf: 0, slot: 0} -> 103 after 0.04
        C-DS {order_id: 99} -> 103 after 0.04
        C-BS {side: OUTPUT} -> 103 after 0.04
        C-RS1 {ring_color: RING_BLUE} -> 103 after 0.04
        C-CS1 is BROKEN
        C-SS is BROKEN
        C-DS is BROKEN
        C-BS is BROKEN
        C-RS1 is BROKEN)"},
      {"breaking: a buffered cap is taken back",
       R"(lay BASE_CLEAR CAP_GREY at C-CS1-INPUT
        C-CS1 {operation: RETRIEVE_CAP} -> 0
        points buffer 2
        C-CS1 {operation: RESET} -> 0
        wait 0
        points
        loaded C-CS1 1
        wait 30.2
        loaded C-CS1 0
        wait 31
        C-CS1 {operation: MOUNT_CAP} -> 103)"},
      {"breaking: delivery prepared 40 s before its window",
       R"(order C0 BASE_RED CAP_GREY window 40 100
        lay BASE_RED CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 202 after 20.04
        C-DS is BROKEN
        belt C-DS nothing
        verdict none)",
       kBox},
      {"breaking: delivery prepared 40 s before its window waits for it",
       R"(order C0 BASE_RED CAP_GREY window 40 100
        lay BASE_RED CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0 after 43.77
        verdict correct
        points delivery 20 cap 10)",
       kBook},
      {"breaking: delivery prepared 15 s before its window waits for it",
       R"(order C0 BASE_RED CAP_GREY window 15 100
        lay BASE_RED CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0 after 18.77
        verdict correct)"},

  };
  return kRows;
}

}  // namespace cxlab::rcll
