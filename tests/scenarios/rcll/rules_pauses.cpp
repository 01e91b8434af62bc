// A paused game: its time stands, and all that goes by it.

#include "rules_table.h"

namespace cxlab::rcll {

std::span<const Row> pause_rows() {
  static const Row kRows[] = {
      {"pause: time and state of the game",
       R"(pause 10 5
        until 9.9
        message /game_state /state "RUNNING"
        until 10.06
        message /game_state /state "PAUSED"
        message /game_state /phase "PRODUCTION"
        message /game_state /game_time 10.0
        until 14.9
        message /game_state /state "PAUSED"
        message /game_state /game_time 10.0
        until 15.06
        message /game_state /state "RUNNING"
        until 18.1
        message /game_state /game_time 13.0)"},
      {"pause: topics go on",
       R"(pause 10 20
        until 10.1
        published /game_state 10
        until 29.9
        published /game_state 19
        message /game_state /state "PAUSED")"},
      {"pause: the referee writes down what paused the game and what let it go on",
       R"(pause 10 5
        until 11
        told {"event": "state", "state": "PAUSED", "cause": "scenario", "game_time": 10.0}
        until 16
        told {"event": "state", "state": "RUNNING", "cause": "scenario", "game_time": 10.0})"},
      {"pause: each moves those that follow",
       R"(pause 20 10
        pause 10 5
        pause 30 1
        until 11
        message /game_state /state "PAUSED"
        until 24.9
        message /game_state /state "RUNNING"
        until 25.1
        message /game_state /state "PAUSED"
        message /game_state /game_time 20.0
        until 34.9
        message /game_state /state "PAUSED"
        until 36.1
        message /game_state /game_time 21.0)"},
      {"pause: seconds of production count, not those of the set-up",
       R"(setup 5
        pause 10 5
        until 14.9
        message /game_state /state "RUNNING"
        until 15.1
        message /game_state /state "PAUSED")"},
      {"pause: production ends later",
       R"(production 30
        overtime 0
        pause 10 5
        until 34.9
        phase PRODUCTION
        until 35.1
        phase POST_GAME)"},
      {"pause: set-up ends later",
       R"(setup 10
        state PAUSED
        until 20
        state RUNNING
        until 29
        phase SETUP
        until 30.2
        phase PRODUCTION)"},
      {"pause: an order comes later",
       R"(order C0 BASE_RED CAP_GREY known 12
        pause 10 5
        until 16.9
        message /order_info /orders []
        until 17.1
        message /order_info /orders/0/id 1)"},
      {"pause: the window of an order is that of the game's time",
       R"(order C0 BASE_RED CAP_GREY window 0 12
        pause 10 5
        until 12
        lay BASE_RED CAP_GREY at C-DS-INPUT
        until 15.5
        C-DS {order_id: 1} -> 0 after 3.746
        late 2.27
        verdict correct
        points delivery 20 cap 10 late -3)",
       kBox},
      {"pause: a product in time is in time after it",
       R"(order C0 BASE_RED CAP_GREY window 0 16
        pause 10 5
        until 12
        lay BASE_RED CAP_GREY at C-DS-INPUT
        until 15.5
        C-DS {order_id: 1} -> 0
        late 0
        points delivery 20 cap 10)"},
      {"pause: a delivery station waits for the game's time",
       R"(order C0 BASE_RED CAP_GREY window 15 100
        pause 5 10
        lay BASE_RED CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1}
        until 24.9
        C-DS is PREPARED
        until 25.1
        C-DS is PROCESSING
        ends 0
        verdict correct)"},
      {"pause: a machine at work stands, and goes on",
       R"(pause 10 5
        lay BASE_CLEAR CAP_BLACK at C-CS2-INPUT
        C-CS2 {operation: RETRIEVE_CAP}
        until 14
        C-CS2 is PROCESSING
        lights C-CS2 OFF ON ON
        until 23.9
        C-CS2 is PROCESSING
        points
        ends 0 after 26.694
        points buffer 2)"},
      {"pause: a belt stands with its workpiece",
       R"(pause 2 5
        C-BS {side: OUTPUT, base_color: BASE_RED}
        until 6.9
        belt C-BS BASE_RED
        at C-BS-OUTPUT nothing
        ends 0 after 8.756
        at C-BS-OUTPUT BASE_RED)"},
      {"pause: the time without a workpiece stands",
       R"(pause 10 5
        C-CS1 {operation: RETRIEVE_CAP}
        until 24.9
        C-CS1 is PREPARED
        until 25.2
        C-CS1 is BROKEN
        ends 202)"},
      {"pause: BROKEN lasts 30 s of the game",
       R"(pause 10 5
        C-CS1 {operation: RESET} -> 0
        until 34.9
        C-CS1 is BROKEN
        until 35.2
        C-CS1 is IDLE)"},
      {"pause: WAIT-IDLE lasts 5 s of the game",
       R"(pause 5 5
        C-BS {side: OUTPUT, base_color: BASE_RED} -> 0
        take C-BS-OUTPUT
        wait 0
        C-BS is WAIT-IDLE
        until 13.7
        C-BS is WAIT-IDLE
        until 14
        C-BS is IDLE)"},
      {"pause: READY-AT-OUTPUT ends when the game goes on",
       R"(pause 5 5
        C-BS {side: OUTPUT, base_color: BASE_RED} -> 0
        until 6
        take C-BS-OUTPUT
        until 9.9
        C-BS is READY-AT-OUTPUT
        until 10.1
        C-BS is WAIT-IDLE)"},
      {"pause: DOWN lasts as long as it was to last",
       R"(pause 5 5
        down C-CS1 10
        wait 1
        C-CS1 is DOWN
        until 14.9
        C-CS1 is DOWN
        until 15.1
        C-CS1 is IDLE)"},
      {"pause: an empty shelf is filled later",
       R"(refill 20
        take C-CS1-SHELF-LEFT
        drop
        take C-CS1-SHELF-MIDDLE
        drop
        take C-CS1-SHELF-RIGHT
        state PAUSED
        until 10
        state RUNNING
        until 29.8
        at C-CS1-SHELF-LEFT nothing
        until 30.4
        at C-CS1-SHELF-LEFT BASE_CLEAR CAP_GREY)"},
      {"pause: a payment is seen when the game goes on",
       R"(hold BASE_RED
        state PAUSED
        put C-RS1-SLIDE
        wait 5
        loaded C-RS1 0
        points
        state RUNNING
        loaded C-RS1 1
        points payment 2)"},
      {"pause: no machine takes an instruction, and none breaks by it",
       R"(pause 1 5
        C-BS {side: OUTPUT, base_color: BASE_RED}
        until 3
        C-BS {side: OUTPUT, base_color: BASE_RED} -> 209
        C-CS1 {operation: MOUNT_CAP} -> 209
        C-CS2 {operation: RESET} -> 209
        told {"event": "instruction", "machine": "C-CS2", "code": 209}
        until 7
        C-BS is PROCESSED
        C-CS1 is IDLE
        C-CS2 is IDLE
        C-CS2 {operation: RESET} -> 0)"},
      {"pause: a report is judged when the game goes on",
       R"(exploration
        pause 10 5
        until 11
        report C-CS1 RIGHT RIGHT
        until 14.9
        points
        message /machine_report_info /reported_machines []
        until 16.1
        points exploration 2
        message /machine_report_info /reported_machines ["C-CS1"])"},
      {"pause: exploration lasts 180 s of the game",
       R"(exploration
        pause 10 5
        until 184.9
        C-BS {side: OUTPUT, base_color: BASE_RED} -> 209
        until 185.1
        C-BS {side: OUTPUT, base_color: BASE_RED} -> 0)"},
      {"pause: a request for maintenance waits until the game goes on",
       R"(pause 10 5
        until 11
        maintenance 1
        until 14.9
        message /robot_info /robots/0/state "ACTIVE"
        robot 1 at 4.5 0.5
        until 15.2
        message /robot_info /robots/0/state "MAINTENANCE"
        robot 1 at 4.5 -0.6)"},
      {"pause: maintenance lasts as long as in the game",
       R"(repair 20
        pause 10 5
        maintenance 1
        maintenance 1 ends
        until 12.6
        message /robot_info /robots/0/maintenance_time_remaining 110.04000091552734
        until 24.9
        robot 1 at 4.5 -0.6
        until 25.2
        robot 1 at 4.5 0.5
        told {"event": "maintenance", "state": "end", "duration_s": 20.0})"},
      {"pause: the limit of 135 s moves too",
       R"(pause 100 50
        maintenance 1
        until 184.9
        message /robot_info /robots/0/state "MAINTENANCE"
        until 185.2
        message /robot_info /robots/0/state "DISQUALIFIED")"},
      {"pause: faults strike by the game's time",
       R"(fault 10 1 20
        pause 5 5
        until 14.9
        message /robot_info /robots/0/state "ACTIVE"
        until 15.2
        message /robot_info /robots/0/state "MAINTENANCE")"},
      {"pause: somebody asks for it, until it is asked to go on",
       R"(until 10
        state PAUSED
        answer done
        message /game_state /state "PAUSED"
        told {"event": "state", "state": "PAUSED", "cause": "request", "by": "/agent"}
        until 70
        message /game_state /state "PAUSED"
        state RUNNING
        answer done
        message /game_state /state "RUNNING"
        told {"event": "state", "state": "RUNNING", "cause": "request", "by": "/agent"}
        until 75.2
        message /game_state /game_time 15.0)"},
      {"pause: to ask for the state that it has changes nothing",
       R"(pause 10 5
        state RUNNING
        answer done
        until 11
        state PAUSED
        answer done
        told {"event": "state", "cause": "scenario"}
        until 15.1
        message /game_state /state "RUNNING")"},
      {"pause: a listed one can be ended before its time",
       R"(pause 10 50
        until 12
        state RUNNING
        until 70
        message /game_state /state "RUNNING"
        told {"event": "state", "cause": "request"})"},
      {"pause: one that is asked for after a listed one lasts until it is asked to go on",
       R"(pause 10 5
        until 12
        state RUNNING
        state PAUSED
        until 20
        message /game_state /state "PAUSED"
        state RUNNING
        message /game_state /state "RUNNING")"},
      {"pause: a game that is decided has none in the overtime that does not come",
       R"(production 10
        overtime 20
        pause 15 5
        hold BASE_RED
        put C-RS1-SLIDE
        until 11
        phase POST_GAME
        until 16
        message /game_state /state "RUNNING")"},
      {"pause: no other states can be asked for",
       R"(state INIT
        answer state: found 'INIT', expected RUNNING or PAUSED
        wait 2
        message /game_state /state "RUNNING")"},
      {"pause: none after the game",
       R"(production 10
        overtime 0
        until 11
        state PAUSED
        answer the game is over
        wait 2
        message /game_state /state "RUNNING")"},
      {"pause: overtime comes later",
       R"(production 10
        overtime 20
        pause 15 5
        until 10.1
        phase PRODUCTION
        until 34.9
        phase PRODUCTION
        message /game_state /game_time 29.0
        until 35.1
        phase POST_GAME)",
       kBox},
  };
  return kRows;
}

}  // namespace cxlab::rcll
