// What machines accept, and what a second instruction does.

#include "rules_table.h"

namespace cxlab::rcll {

std::span<const Row> instruction_rows() {
  static const Row kRows[] = {
      {"instructions: a base station gives each colour at either side",
       R"(C-BS {side: OUTPUT, base_color: BASE_RED} -> 0
        at C-BS-OUTPUT BASE_RED
        at C-BS-INPUT nothing
        take C-BS-OUTPUT
        wait 6
        C-BS {side: INPUT, base_color: BASE_BLACK} -> 0
        at C-BS-INPUT BASE_BLACK
        at C-BS-OUTPUT nothing
        drop
        take C-BS-INPUT
        wait 6
        C-BS {side: INPUT, base_color: BASE_SILVER} -> 0
        at C-BS-INPUT BASE_SILVER)"},
      {"instructions: none at the moment at which the machine goes down",
       R"(down C-BS 5
        C-BS {side: OUTPUT, base_color: BASE_RED} -> 209
        C-BS is DOWN)"},
      {"instructions: taken at the moment at which the machine is IDLE again",
       R"(down C-BS 5
        wait 4.98
        C-BS is DOWN
        C-BS {side: OUTPUT, base_color: BASE_RED} -> 0)"},
      {"instructions: a base station without a side breaks",
       R"(C-BS {base_color: BASE_RED} -> 103
        C-BS is BROKEN)"},
      {"instructions: a base station without a colour breaks",
       R"(C-BS {side: OUTPUT} -> 103
        C-BS is BROKEN)"},
      {"instructions: a base station has no clear bases and breaks",
       R"(C-BS {side: OUTPUT, base_color: BASE_CLEAR} -> 103
        C-BS is BROKEN)"},
      {"instructions: a cap station without an operation breaks",
       R"(C-CS1 {operation: MOUNT} -> 103
        C-CS1 is BROKEN)"},
      {"instructions: with a cap buffered another operation breaks it as well",
       R"(lay BASE_CLEAR CAP_GREY at C-CS1-INPUT
        C-CS1 {operation: RETRIEVE_CAP} -> 0
        take C-CS1-OUTPUT
        wait 6
        C-CS1 {operation: MOUNT} -> 103
        C-CS1 is BROKEN)"},
      {"instructions: RETRIEVE_CAP while a cap is buffered breaks a cap station",
       R"(lay BASE_CLEAR CAP_GREY at C-CS1-INPUT
        C-CS1 {operation: RETRIEVE_CAP} -> 0
        take C-CS1-OUTPUT
        wait 6
        loaded C-CS1 1
        C-CS1 {operation: RETRIEVE_CAP} -> 103
        C-CS1 is BROKEN
        loaded C-CS1 1
        wait 0
        points)"},
      {"instructions: MOUNT_CAP while no cap is buffered breaks a cap station",
       R"(C-CS1 {operation: MOUNT_CAP} -> 103
        C-CS1 is BROKEN)"},
      {"instructions: a delivery station breaks on an order that does not exist",
       R"(C-DS {order_id: 3} -> 103
        C-DS is BROKEN)"},
      {"instructions: a delivery station accepts an order that is not active yet",
       R"(order C0 BASE_RED CAP_GREY known 100
        lay BASE_RED CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        verdict inactive
        points)"},
      {"instructions: order 0 discards, without points",
       R"(lay BASE_RED CAP_GREY at C-DS-INPUT
        C-DS {order_id: 0} -> 0
        belt C-DS nothing
        verdict none
        points)"},
      {"instructions: machines of the other team obey it alone",
       R"(M-BS {side: OUTPUT, base_color: BASE_RED} -> 101
        M-BS is IDLE)"},
      {"instructions: MAGENTA has the machines of its own",
       R"(team MAGENTA
        C-BS {side: OUTPUT, base_color: BASE_RED} -> 101
        M-BS {side: OUTPUT, base_color: BASE_RED} -> 0
        M-BS is READY-AT-OUTPUT)"},
      {"instructions: a machine that does not exist", "C-CS3 {operation: RETRIEVE_CAP} -> 203"},
      {"instructions: none is accepted before production",
       R"(setup 10
        C-BS {side: OUTPUT} -> 209
        C-BS is IDLE
        C-BS {operation: RESET} -> 209
        C-BS is IDLE
        until 10
        C-BS {side: OUTPUT, base_color: BASE_RED} -> 0)"},
      {"instructions: none is accepted after the game",
       R"(production 10
        overtime 0
        until 10
        C-BS {side: OUTPUT, base_color: BASE_RED} -> 209
        C-BS is IDLE)"},
      {"instructions: a machine goes on with its work when nobody waits for it any more",
       R"(C-BS {side: OUTPUT, base_color: BASE_RED}
        wait 1
        cancel
        ends cancelled
        wait 5
        C-BS is READY-AT-OUTPUT)"},

      {"second instruction: ignored while PREPARED",
       R"(C-CS1 {operation: RETRIEVE_CAP}
        wait 1
        C-CS1 is PREPARED
        C-CS1 {operation: RETRIEVE_CAP} -> 209
        C-CS1 is PREPARED)",
       kBox},
      {"second instruction: breaks while PREPARED",
       R"(C-CS1 {operation: RETRIEVE_CAP}
        wait 1
        C-CS1 is PREPARED
        C-CS1 {operation: RETRIEVE_CAP} -> 209
        C-CS1 is BROKEN)",
       kBook},
      {"second instruction: ignored while PROCESSING",
       R"(C-BS {side: OUTPUT, base_color: BASE_RED}
        wait 0.5
        C-BS is PROCESSING
        C-BS {side: OUTPUT, base_color: BASE_BLACK} -> 209
        C-BS is PROCESSING
        wait 4
        at C-BS-OUTPUT BASE_RED)",
       kBox},
      {"second instruction: breaks while PROCESSING, the first ends with code 1",
       R"(C-BS {side: OUTPUT, base_color: BASE_RED}
        wait 0.5
        C-BS is PROCESSING
        C-BS {side: OUTPUT, base_color: BASE_BLACK} -> 209
        C-BS is BROKEN
        before ends 1)",
       kBook},
      {"second instruction: ignored while PROCESSED",
       R"(C-BS {side: OUTPUT, base_color: BASE_RED}
        wait 2
        C-BS is PROCESSED
        C-BS {side: OUTPUT, base_color: BASE_BLACK} -> 209
        C-BS is PROCESSED)",
       kBox},
      {"second instruction: breaks while PROCESSED",
       R"(C-BS {side: OUTPUT, base_color: BASE_RED}
        wait 2
        C-BS is PROCESSED
        C-BS {side: OUTPUT, base_color: BASE_BLACK} -> 209
        C-BS is BROKEN)",
       kBook},
      {"second instruction: ignored in READY-AT-OUTPUT",
       R"(C-BS {side: OUTPUT, base_color: BASE_RED} -> 0
        C-BS {side: OUTPUT, base_color: BASE_BLACK} -> 209
        C-BS is READY-AT-OUTPUT
        at C-BS-OUTPUT BASE_RED)",
       kBox},
      {"second instruction: breaks in READY-AT-OUTPUT",
       R"(C-BS {side: OUTPUT, base_color: BASE_RED} -> 0
        C-BS is READY-AT-OUTPUT
        C-BS {side: OUTPUT, base_color: BASE_BLACK} -> 209
        C-BS is BROKEN
        at C-BS-OUTPUT nothing)",
       kBook},
      {"second instruction: ignored in WAIT-IDLE",
       R"(C-BS {side: OUTPUT, base_color: BASE_RED} -> 0
        take C-BS-OUTPUT
        wait 1
        C-BS is WAIT-IDLE
        C-BS {side: OUTPUT, base_color: BASE_BLACK} -> 209
        C-BS is WAIT-IDLE)",
       kBox},
      {"second instruction: breaks in WAIT-IDLE",
       R"(C-BS {side: OUTPUT, base_color: BASE_RED} -> 0
        take C-BS-OUTPUT
        wait 1
        C-BS is WAIT-IDLE
        C-BS {side: OUTPUT, base_color: BASE_BLACK} -> 209
        C-BS is BROKEN)",
       kBook},
      {"second instruction: ignored while BROKEN, whose 30 s go on",
       R"(C-BS {operation: RESET} -> 0
        wait 20
        C-BS {side: OUTPUT, base_color: BASE_RED} -> 209
        C-BS is BROKEN
        wait 10.1
        C-BS is IDLE)"},
      {"second instruction: ignored while DOWN, also a wrong one",
       R"(down C-BS 10
        wait 1
        C-BS is DOWN
        C-BS {side: OUTPUT, base_color: BASE_RED} -> 209
        C-BS {side: OUTPUT} -> 209
        C-BS is DOWN
        wait 10
        C-BS is IDLE)"},

  };
  return kRows;
}

}  // namespace cxlab::rcll
