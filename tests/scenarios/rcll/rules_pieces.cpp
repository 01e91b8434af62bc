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
        loaded C-RS2 0
        points)"},
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
        rival points payment 2)"},

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
        loaded C-CS1 0
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
