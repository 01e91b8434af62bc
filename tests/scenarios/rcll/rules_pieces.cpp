// What machines take in and keep: payments at ring stations, caps.

#include "rules_table.h"

namespace cxlab::rcll {

std::span<const Row> piece_rows() {
  static const Row kRows[] = {
      {"payments: a base on the slide is +2, any colour",
       R"(hold BASE_RED
        put C-RS1-SLIDE
        wait 0.04
        loaded C-RS1 1
        points payment 2
        hold BASE_BLACK
        put C-RS1-SLIDE
        wait 0.04
        loaded C-RS1 2
        points payment 4
        hold BASE_SILVER
        put C-RS2-SLIDE
        wait 0.04
        loaded C-RS1 2
        loaded C-RS2 1
        points payment 6)"},
      {"payments: a clear base and a carrier with its cap count",
       R"(hold BASE_CLEAR
        put C-RS1-SLIDE
        hold BASE_CLEAR CAP_BLACK
        put C-RS1-SLIDE
        wait 0.04
        loaded C-RS1 2
        points payment 4)"},
      {"payments: the fourth unused base breaks the ring station, which takes all back",
       R"(hold BASE_RED
        put C-RS2-SLIDE
        hold BASE_RED
        put C-RS2-SLIDE
        hold BASE_RED
        put C-RS2-SLIDE
        wait 0.04
        C-RS2 is IDLE
        points payment 6
        hold BASE_RED
        put C-RS2-SLIDE
        wait 0.04
        C-RS2 is BROKEN
        loaded C-RS2 3
        points
        wait 30.2
        C-RS2 is IDLE
        loaded C-RS2 0)"},
      {"payments: the fourth unused base earns nothing before the three others are taken back",
       R"(hold BASE_RED
        put C-RS2-SLIDE
        hold BASE_RED
        put C-RS2-SLIDE
        hold BASE_RED
        put C-RS2-SLIDE
        hold BASE_RED
        put C-RS2-SLIDE
        wait 0.04
        given payment 2 payment 2 payment 2 payment -6)"},
      {"payments: one that comes just before an instruction counts for it",
       R"(hold BASE_RED
        put C-RS2-SLIDE
        C-RS2 {ring_color: RING_BLUE}
        wait 0.02
        C-RS2 is PREPARED)"},
      {"payments: a fourth base just before an instruction breaks the ring station, which does not take it",
       R"(hold BASE_RED
        put C-RS2-SLIDE
        hold BASE_RED
        put C-RS2-SLIDE
        hold BASE_RED
        put C-RS2-SLIDE
        hold BASE_RED
        put C-RS2-SLIDE
        C-RS2 {ring_color: RING_BLUE} -> 209
        C-RS2 is BROKEN)"},
      {"payments: the fourth base while the ring station is DOWN breaks it",
       R"(hold BASE_RED
        put C-RS2-SLIDE
        hold BASE_RED
        put C-RS2-SLIDE
        hold BASE_RED
        put C-RS2-SLIDE
        down C-RS2 10
        wait 1
        hold BASE_RED
        put C-RS2-SLIDE
        wait 0.04
        C-RS2 is DOWN
        points
        wait 9.5
        C-RS2 is BROKEN
        wait 21
        C-RS2 is IDLE)"},
      {"payments: none before production",
       R"(setup 10
        hold BASE_RED
        put C-RS1-SLIDE
        until 11
        loaded C-RS1 0
        points
        hold BASE_RED
        put C-RS1-SLIDE
        wait 0.04
        loaded C-RS1 1
        points payment 2)"},
      {"payments: none while the ring station is BROKEN",
       R"(C-RS1 {operation: RESET} -> 0
        hold BASE_RED
        put C-RS1-SLIDE
        wait 0.04
        loaded C-RS1 0
        points
        wait 31
        C-RS1 is IDLE
        loaded C-RS1 0
        points
        hold BASE_RED
        put C-RS1-SLIDE
        wait 0.04
        loaded C-RS1 1
        points payment 2)"},
      {"payments: one while the ring station is DOWN counts",
       R"(down C-RS1 30
        wait 1
        hold BASE_RED
        put C-RS1-SLIDE
        wait 0.04
        C-RS1 is DOWN
        loaded C-RS1 1
        points payment 2)"},
      {"payments: a base on the other team's slide is that team's",
       R"(hold BASE_RED
        put M-RS1-SLIDE
        wait 0.04
        points
        rival points payment 2)",
       kBox},

      {"rings: a free one needs no payment",
       R"(lay BASE_RED at C-RS2-INPUT
        C-RS2 {ring_color: RING_YELLOW} -> 0
        at C-RS2-OUTPUT BASE_RED RING_YELLOW
        points)"},
      {"rings: one of price 1 uses one payment up when it is mounted",
       R"(hold BASE_RED
        put C-RS2-SLIDE
        hold BASE_RED
        put C-RS2-SLIDE
        wait 0.04
        lay BASE_BLACK at C-RS2-INPUT
        C-RS2 {ring_color: RING_BLUE}
        wait 1.4
        loaded C-RS2 2
        wait 0.3
        loaded C-RS2 1
        ends 0
        at C-RS2-OUTPUT BASE_BLACK RING_BLUE
        points payment 4)"},
      {"rings: one of price 2 uses two payments up",
       R"(hold BASE_RED
        put C-RS1-SLIDE
        hold BASE_CLEAR
        put C-RS1-SLIDE
        wait 0.04
        lay BASE_SILVER RING_YELLOW at C-RS1-INPUT
        C-RS1 {ring_color: RING_GREEN} -> 0
        at C-RS1-OUTPUT BASE_SILVER RING_YELLOW RING_GREEN
        loaded C-RS1 0
        points payment 4)"},
      {"rings: three on one base",
       R"(lay BASE_RED at C-RS1-INPUT
        C-RS1 {ring_color: RING_ORANGE} -> 0
        take C-RS1-OUTPUT
        put C-RS2-INPUT
        C-RS2 {ring_color: RING_YELLOW} -> 0
        take C-RS2-OUTPUT
        wait 6
        put C-RS1-INPUT
        C-RS1 {ring_color: RING_ORANGE} -> 0
        at C-RS1-OUTPUT BASE_RED RING_ORANGE RING_YELLOW RING_ORANGE)"},
      {"rings: a payment too few breaks the ring station, and what was paid is taken back",
       R"(hold BASE_RED
        put C-RS1-SLIDE
        wait 0.04
        lay BASE_RED at C-RS1-INPUT
        C-RS1 {ring_color: RING_GREEN} -> 103
        C-RS1 is BROKEN
        points)"},
      {"rings: a colour that the station does not have breaks it",
       R"(C-RS1 {ring_color: RING_BLUE} -> 103
        C-RS1 is BROKEN
        C-RS2 {ring_color: RING_RED} -> 103
        C-RS2 is BROKEN)"},
      {"rings: none on a workpiece with a cap",
       R"(lay BASE_RED CAP_GREY at C-RS1-INPUT
        C-RS1 {ring_color: RING_ORANGE} -> 103
        C-RS1 is BROKEN)"},
      {"rings: no fourth",
       R"(lay BASE_RED RING_BLUE RING_GREEN RING_YELLOW at C-RS1-INPUT
        C-RS1 {ring_color: RING_ORANGE} -> 103
        C-RS1 is BROKEN)"},

      {"storage: a C0 lies in slot 1 of each shelf",
       R"(C-SS {operation: RETRIEVE, shelf: 0, slot: 1} -> 0
        at C-SS-OUTPUT BASE_RED CAP_GREY
        take C-SS-OUTPUT
        drop
        wait 6
        C-SS {operation: RETRIEVE, shelf: 1, slot: 1} -> 0
        at C-SS-OUTPUT BASE_RED CAP_BLACK
        take C-SS-OUTPUT
        drop
        wait 6
        C-SS {operation: RETRIEVE, shelf: 2, slot: 1} -> 0
        at C-SS-OUTPUT BASE_SILVER CAP_GREY
        take C-SS-OUTPUT
        drop
        wait 6
        C-SS {operation: RETRIEVE, shelf: 3, slot: 1} -> 0
        at C-SS-OUTPUT BASE_SILVER CAP_BLACK
        take C-SS-OUTPUT
        drop
        wait 6
        C-SS {operation: RETRIEVE, shelf: 4, slot: 1} -> 0
        at C-SS-OUTPUT BASE_BLACK CAP_GREY
        take C-SS-OUTPUT
        drop
        wait 6
        C-SS {operation: RETRIEVE, shelf: 5, slot: 1} -> 0
        at C-SS-OUTPUT BASE_BLACK CAP_BLACK
        points penalty -30)",
       kBox},
      {"storage: what is stored comes out again, 5 points each way",
       R"(lay BASE_BLACK RING_BLUE at C-SS-INPUT
        C-SS {operation: STORE, shelf: 3, slot: 4} -> 0
        belt C-SS nothing
        points penalty -5
        wait 5.2
        C-SS is IDLE
        C-SS {operation: RETRIEVE, shelf: 3, slot: 4} -> 0
        at C-SS-OUTPUT BASE_BLACK RING_BLUE
        points penalty -10)"},
      {"storage: what lies in front is moved first, for nothing",
       R"(lay BASE_BLACK at C-SS-INPUT
        C-SS {operation: STORE, shelf: 0, slot: 0} -> 0
        wait 6
        C-SS {operation: RETRIEVE, shelf: 0, slot: 1} -> 0 after 37.656
        at C-SS-OUTPUT BASE_RED CAP_GREY
        points penalty -10
        take C-SS-OUTPUT
        wait 6
        C-SS {operation: RETRIEVE, shelf: 0, slot: 0} -> 103
        C-SS is BROKEN)"},
      {"storage: behind a workpiece a new one is stored after that was moved",
       R"(lay BASE_BLACK at C-SS-INPUT
        C-SS {operation: STORE, shelf: 0, slot: 2} -> 0
        wait 6
        lay BASE_SILVER at C-SS-INPUT
        C-SS {operation: STORE, shelf: 0, slot: 3} -> 0 after 36.538
        wait 6
        C-SS {operation: RETRIEVE, shelf: 0, slot: 3} -> 0 after 20.156
        at C-SS-OUTPUT BASE_SILVER)"},
      {"storage: a filled slot to store in breaks it",
       R"(C-SS {operation: STORE, shelf: 0, slot: 1} -> 103
        C-SS is BROKEN)"},
      {"storage: an empty slot to retrieve from breaks it",
       R"(C-SS {operation: RETRIEVE, shelf: 0, slot: 0} -> 103
        C-SS is BROKEN)"},
      {"storage: shelves are 0 to 5",
       R"(C-SS {operation: STORE, shelf: 6, slot: 0} -> 103
        C-SS is BROKEN)"},
      {"storage: slots are 0 to 7",
       R"(C-SS {operation: STORE, shelf: 5, slot: 8} -> 103
        C-SS is BROKEN)"},
      {"storage: the last shelf and slot are there",
       R"(lay BASE_RED at C-SS-INPUT
        C-SS {operation: STORE, shelf: 5, slot: 7} -> 0)"},
      {"storage: another operation breaks it",
       R"(C-SS {operation: MOUNT_CAP, shelf: 0, slot: 1} -> 103
        C-SS is BROKEN)"},
      {"storage: what the team says of a slot changes at once and costs nothing",
       R"(C-SS {operation: CHANGE_INFO, shelf: 0, slot: 1, description: ours} -> 0 after 0.04
        C-SS is IDLE
        points)"},
      {"storage: what a team says of an empty slot is refused and breaks nothing",
       R"(C-SS {operation: CHANGE_INFO, shelf: 0, slot: 0, description: ours} -> 103
        C-SS is IDLE
        lay BASE_RED at C-SS-INPUT
        C-SS {operation: STORE, shelf: 0, slot: 0, description: red} -> 0
        wait 7
        message /machine_info /machines/5/status_ss/0 {"shelf": 0, "slot": 0, "is_filled": true, "description": "red"}
        C-SS {operation: RETRIEVE, shelf: 0, slot: 0} -> 0
        wait 2
        message /machine_info /machines/5/status_ss/0/slot 1)"},
      {"storage: what a team says of a slot that does not exist breaks it",
       R"(C-SS {operation: CHANGE_INFO, shelf: 0, slot: 8, description: ours} -> 103
        C-SS is BROKEN)"},
      {"storage: what a team says of a slot that another blocks is noted",
       R"(lay BASE_RED at C-SS-INPUT
        C-SS {operation: STORE, shelf: 0, slot: 0} -> 0
        wait 6
        C-SS {operation: CHANGE_INFO, shelf: 0, slot: 1, description: behind} -> 0
        wait 2.1
        message /machine_info /machines/5/status_ss/1/description "behind")"},
      {"storage: nothing to store, 20 s after the instruction it breaks",
       R"(C-SS {operation: STORE, shelf: 0, slot: 0} -> 202 after 20.04
        C-SS is BROKEN)"},

      {"caps: the carrier comes out as a clear base, the cap is buffered and worth 2",
       R"(lay BASE_CLEAR CAP_GREY at C-CS1-INPUT
        C-CS1 {operation: RETRIEVE_CAP} -> 0
        at C-CS1-OUTPUT BASE_CLEAR
        loaded C-CS1 1
        points buffer 2)"},
      {"caps: mounting uses the buffered cap up",
       R"(lay BASE_CLEAR CAP_BLACK at C-CS1-INPUT
        C-CS1 {operation: RETRIEVE_CAP} -> 0
        take C-CS1-OUTPUT
        wait 6
        lay BASE_RED at C-CS1-INPUT
        C-CS1 {operation: MOUNT_CAP} -> 0
        at C-CS1-OUTPUT BASE_RED CAP_BLACK
        loaded C-CS1 0
        points buffer 2
        drop
        take C-CS1-OUTPUT
        wait 6
        C-CS1 {operation: MOUNT_CAP} -> 103
        C-CS1 is BROKEN)"},
      {"caps: a product with rings gets its cap on top",
       R"(lay BASE_CLEAR CAP_BLACK at C-CS1-INPUT
        C-CS1 {operation: RETRIEVE_CAP} -> 0
        take C-CS1-OUTPUT
        wait 6
        lay BASE_SILVER RING_GREEN RING_BLUE RING_GREEN at C-CS1-INPUT
        C-CS1 {operation: MOUNT_CAP} -> 0
        at C-CS1-OUTPUT BASE_SILVER RING_GREEN RING_BLUE RING_GREEN CAP_BLACK)"},
      {"caps: a second cap on a capped product breaks the cap station",
       R"(lay BASE_CLEAR CAP_GREY at C-CS1-INPUT
        C-CS1 {operation: RETRIEVE_CAP} -> 0
        take C-CS1-OUTPUT
        wait 6
        lay BASE_RED CAP_BLACK at C-CS1-INPUT
        C-CS1 {operation: MOUNT_CAP} -> 103
        C-CS1 is BROKEN
        loaded C-CS1 1
        points)"},
      {"caps: RETRIEVE_CAP from a workpiece without a cap breaks the cap station",
       R"(lay BASE_CLEAR at C-CS1-INPUT
        C-CS1 {operation: RETRIEVE_CAP} -> 103
        C-CS1 is BROKEN
        points)"},
      {"caps: the shelf of CS1 has grey caps, that of CS2 black ones",
       R"(at C-CS1-SHELF-LEFT BASE_CLEAR CAP_GREY
        at C-CS1-SHELF-MIDDLE BASE_CLEAR CAP_GREY
        at C-CS1-SHELF-RIGHT BASE_CLEAR CAP_GREY
        at C-CS2-SHELF-LEFT BASE_CLEAR CAP_BLACK
        at M-CS1-SHELF-RIGHT BASE_CLEAR CAP_GREY
        at M-CS2-SHELF-MIDDLE BASE_CLEAR CAP_BLACK)"},
      {"caps: a shelf is filled again 20 s after its last carrier was taken, not before",
       R"(take C-CS1-SHELF-LEFT
        drop
        take C-CS1-SHELF-MIDDLE
        drop
        wait 30
        at C-CS1-SHELF-LEFT nothing
        take C-CS1-SHELF-RIGHT
        wait 19.8
        at C-CS1-SHELF-RIGHT nothing
        wait 0.4
        at C-CS1-SHELF-LEFT BASE_CLEAR CAP_GREY
        at C-CS1-SHELF-MIDDLE BASE_CLEAR CAP_GREY
        at C-CS1-SHELF-RIGHT BASE_CLEAR CAP_GREY)"},
      {"caps: a carrier that is put back counts as one on the shelf",
       R"(refill 5
        take C-CS1-SHELF-LEFT
        drop
        take C-CS1-SHELF-MIDDLE
        drop
        take C-CS1-SHELF-RIGHT
        wait 2
        put C-CS1-SHELF-RIGHT
        wait 20
        at C-CS1-SHELF-LEFT nothing)"},
      {"caps: the 20 s begin anew when a carrier lay on the shelf meanwhile",
       R"(refill 5
        take C-CS1-SHELF-LEFT
        drop
        take C-CS1-SHELF-MIDDLE
        drop
        take C-CS1-SHELF-RIGHT
        wait 3
        put C-CS1-SHELF-RIGHT
        wait 1
        take C-CS1-SHELF-RIGHT
        wait 4.8
        at C-CS1-SHELF-LEFT nothing
        wait 0.4
        at C-CS1-SHELF-LEFT BASE_CLEAR CAP_GREY)"},
  };
  return kRows;
}

}  // namespace cxlab::rcll
