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
