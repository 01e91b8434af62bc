// The referee: phases and orders.

#include "rules_table.h"

namespace cxlab::rcll {

std::span<const Row> game_rows() {
  static const Row kRows[] = {
      {"by hand: an instruction without a workpiece costs a point",
       R"(C-CS1 {operation: RETRIEVE_CAP} -> 202
        points penalty -1
        C-DS {order_id: 0} -> 202
        points penalty -2)",
       kBook},
      {"by hand: the referee box sees no instruction without a workpiece",
       R"(C-CS1 {operation: RETRIEVE_CAP} -> 202
        points)",
       kBox},
      {"by hand: a workpiece that lies on the belt but not where it should costs nothing",
       R"(C-CS1 {operation: RETRIEVE_CAP}
        wait 19.9
        lay BASE_RED at C-CS1-OUTPUT
        ends 202
        points)",
       kBook},
      {"by hand: a workpiece that people take out of a machine at work costs nothing",
       R"(C-BS {side: OUTPUT, base_color: BASE_RED}
        wait 2
        remove C-BS
        ends 202
        points)",
       kBook},
      {"by hand: a workpiece dropped costs 10",
       R"(hold BASE_RED
        drop
        wait 0.04
        points penalty -10)",
       kBook},
      {"by hand: the referee box sees nothing fall",
       R"(hold BASE_RED
        drop
        wait 0.04
        points)",
       kBox},
      {"by hand: a workpiece on the other team's machine costs 20 and is taken away",
       R"(hold BASE_RED
        put M-CS1-INPUT
        wait 0.04
        points penalty -20
        belt M-CS1 nothing)",
       kBook},
      {"by hand: a base on the other team's slide is no payment, and no fourth one",
       R"(hold BASE_RED
        put M-RS1-SLIDE
        wait 0.04
        points penalty -20
        rival points
        hold BASE_RED
        put M-RS1-SLIDE
        hold BASE_RED
        put M-RS1-SLIDE
        hold BASE_RED
        put M-RS1-SLIDE
        wait 0.04
        M-RS1 is IDLE
        loaded M-RS1 0)",
       kBook},
      {"by hand: the referee box lets a workpiece lie on the other team's machine",
       R"(hold BASE_RED
        put M-CS1-INPUT
        wait 0.04
        points
        belt M-CS1 BASE_RED)",
       kBox},
      {"points: the league publishes none below 0",
       R"(production 100
        C-SS {operation: RETRIEVE, shelf: 0, slot: 1} -> 0
        points penalty -5
        wait 1.1
        message /game_state /points_cyan 0
        until 100
        message /game_state /phase "PRODUCTION")",
       kBox},
      {"overtime: none when one team leads",
       R"(production 100
        lay BASE_RED CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        until 100
        phase POST_GAME)"},
      {"overtime: 300 s when the teams are even",
       R"(production 100
        lay BASE_RED CAP_GREY at C-DS-INPUT
        lay BASE_RED CAP_GREY at M-DS-INPUT
        C-DS {order_id: 1} -> 0
        rival M-DS {order_id: 1}
        until 100
        phase PRODUCTION
        message /game_state /game_time 100.0
        until 399.98
        phase PRODUCTION
        until 400
        phase POST_GAME)",
       kBox},
      {"overtime: with the referee box also at 0 to 0",
       R"(production 100
        until 100
        phase PRODUCTION
        until 400
        phase POST_GAME)",
       kBox},
      {"overtime: with the rulebook none at 0 to 0",
       R"(production 100
        until 100
        phase POST_GAME)",
       kBook},
      {"overtime: ends with the next points under the rulebook when it was even at its end",
       R"(production 100
        lay BASE_RED CAP_GREY at C-DS-INPUT
        lay BASE_RED CAP_GREY at M-DS-INPUT
        C-DS {order_id: 1} -> 0
        rival M-DS {order_id: 1}
        until 450
        phase PRODUCTION
        hold BASE_RED
        put C-RS1-SLIDE
        wait 0.06
        phase POST_GAME)",
       kBook},
      {"overtime: brings one more order, a competitive C0",
       R"(production 100
        until 99
        message /order_info /orders/0/id 1
        until 101
        message /order_info /orders/1/id 2
        message /order_info /orders/1/complexity "C0"
        message /order_info /orders/1/competitive true
        message /order_info /orders/1/delivery_period_begin 100
        message /order_info /orders/1/delivery_period_end 400)",
       kBox},
      {"phases: set-up, production, the end; each begins its time anew",
       R"(setup 10
        production 20
        overtime 0
        phase SETUP
        until 9
        message /game_state /phase "SETUP"
        message /game_state /game_time 9.0
        until 10
        phase PRODUCTION
        message /game_state /phase "PRODUCTION"
        message /game_state /game_time 0.0
        until 29.98
        phase PRODUCTION
        until 30
        phase POST_GAME
        message /game_state /phase "POST_GAME"
        until 32
        message /game_state /game_time 20.0)"},
      {"phases: machines stand still after the game",
       R"(production 10
        overtime 0
        until 8
        C-BS {side: OUTPUT, base_color: BASE_RED}
        until 30
        C-BS is PROCESSED
        at C-BS-OUTPUT nothing)"},

      {"orders: heard of when they become active, all about them at once",
       R"(order C0 BASE_RED CAP_GREY
        order C2 BASE_SILVER RING_GREEN RING_BLUE CAP_BLACK window 60 100 known 30 gate 3 competitive quantity 2
        until 29.96
        message /order_info /orders/0/id 1
        published /order_info 14
        until 30.02
        published /order_info 1
        message /order_info /orders/1/id 2
        message /order_info /orders/1/complexity "C2"
        message /order_info /orders/1/base_color "BASE_SILVER"
        message /order_info /orders/1/ring_colors ["RING_GREEN", "RING_BLUE"]
        message /order_info /orders/1/cap_color "CAP_BLACK"
        message /order_info /orders/1/quantity_requested 2
        message /order_info /orders/1/delivery_period_begin 60
        message /order_info /orders/1/delivery_period_end 100
        message /order_info /orders/1/delivery_gate 3
        message /order_info /orders/1/competitive true
        message /order_info /orders/0/competitive false)"},
      {"orders: set-up is no time of production",
       R"(setup 10
        order C0 BASE_RED CAP_GREY known 5 window 8 20
        until 14.9
        message /order_info /orders []
        until 15.02
        message /order_info /orders/0/id 1
        lay BASE_RED CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0 after 6.77
        verdict correct)"},
      {"orders: delivered quantities by team",
       R"(order C0 BASE_RED CAP_GREY quantity 2
        lay BASE_RED CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        wait 0
        message /order_info /orders/0/quantity_delivered_cyan 1
        message /order_info /orders/0/quantity_delivered_magenta 0
        lay BASE_RED CAP_GREY at M-DS-INPUT
        rival M-DS {order_id: 1}
        wait 6
        message /order_info /orders/0/quantity_delivered_cyan 1
        message /order_info /orders/0/quantity_delivered_magenta 1
        lay BASE_RED CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        wait 0
        message /order_info /orders/0/quantity_delivered_cyan 2)"},
      {"orders: a wrong product is not counted as delivered",
       R"(lay BASE_BLACK CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        wait 2
        message /order_info /orders/0/quantity_delivered_cyan 0)"},
      {"orders: prices of rings and who mounts them",
       R"(wait 2
        message /ring_info /rings/0 {"ring_color": "RING_BLUE", "raw_material": 1}
        message /ring_info /rings/1 {"ring_color": "RING_GREEN", "raw_material": 2}
        message /ring_info /rings/2 {"ring_color": "RING_ORANGE", "raw_material": 0}
        message /ring_info /rings/3 {"ring_color": "RING_YELLOW", "raw_material": 0}
        message /machine_info /machines/3/name "C-RS1"
        message /machine_info /machines/3/ring_colors ["RING_ORANGE", "RING_GREEN"]
        message /machine_info /machines/4/ring_colors ["RING_BLUE", "RING_YELLOW"]
        message /machine_info /machines/1/cap_color "CAP_GREY"
        message /machine_info /machines/2/cap_color "CAP_BLACK")"},

  };
  return kRows;
}

}  // namespace cxlab::rcll
