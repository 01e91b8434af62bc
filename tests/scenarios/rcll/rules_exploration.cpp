// Exploration: what reports are worth, and what a team may do before it has found its machines.

#include "rules_table.h"

namespace cxlab::rcll {

std::span<const Row> exploration_rows() {
  static const Row kRows[] = {
      {"exploration: a machine that is not reported takes no instruction and does not break",
       R"(exploration
        C-BS {side: OUTPUT, base_color: BASE_RED} -> 209
        C-BS {side: NOWHERE} -> 209
        C-BS is IDLE
        wait 2.1
        message /machine_info /machines/0/name "C-BS"
        message /machine_info /machines/0/correctly_reported false)"},
      {"exploration: its team may reset a machine that is not reported",
       R"(exploration
        C-BS {operation: RESET} -> 0
        C-BS is BROKEN)"},
      {"exploration: zone and rotation right are a point each, and the machine may be used",
       R"(exploration
        report C-BS RIGHT RIGHT
        given exploration 1 exploration 1
        points exploration 2
        message /machine_info /machines/0/correctly_reported true
        message /machine_info /machines/0/exploration_zone_state "CORRECT_REPORT"
        message /machine_info /machines/0/exploration_rotation_state "CORRECT_REPORT"
        C-BS {side: OUTPUT, base_color: BASE_RED} -> 0)"},
      {"exploration: zone and rotation may come one after the other",
       R"(exploration
        report C-BS RIGHT -
        points exploration 1
        message /machine_info /machines/0/exploration_rotation_state "NO_REPORT"
        C-BS {side: OUTPUT, base_color: BASE_RED} -> 209
        report C-BS - RIGHT
        points exploration 2
        C-BS {side: OUTPUT, base_color: BASE_RED} -> 0)"},
      {"exploration: a wrong rotation costs a point",
       R"(exploration
        report C-BS RIGHT WRONG
        given exploration 1 exploration -1
        message /machine_info /machines/0/exploration_rotation_state "WRONG_REPORT"
        C-BS {side: OUTPUT, base_color: BASE_RED} -> 209)"},
      {"exploration: with a wrong zone the rotation is not looked at",
       R"(exploration
        report C-BS WRONG RIGHT
        given exploration -1
        message /machine_info /machines/0/exploration_zone_state "WRONG_REPORT"
        message /machine_info /machines/0/exploration_rotation_state "NO_REPORT")"},
      {"exploration: a rotation before its zone is not looked at",
       R"(exploration
        report C-BS - RIGHT
        given
        report C-BS RIGHT RIGHT
        given exploration 1 exploration 1)"},
      {"exploration: the first value counts",
       R"(exploration
        report C-BS WRONG -
        report C-BS RIGHT RIGHT
        given exploration -1
        report C-DS RIGHT WRONG
        report C-DS RIGHT RIGHT
        given exploration 1 exploration -1)"},
      {"exploration: the other team's machines are not its own",
       R"(exploration
        report M-BS RIGHT RIGHT
        given)"},
      {"exploration: a type in a right zone brings the name and no points",
       R"(exploration
        report - CS RIGHT
        given
        wait 1.1
        message /machine_report_info /reported_types/0/name "C-CS1"
        message /machine_report_info /reported_types/0/type "CS"
        message /machine_report_info /reported_types/0/team_color "CYAN"
        message /machine_report_info /reported_machines [])"},
      {"exploration: a type in a wrong zone costs a point, as often as there are such machines",
       R"(exploration
        report - CS C_Z51
        given exploration -1
        report - CS C_Z51
        given
        report - CS C_Z61
        given exploration -1
        report - CS C_Z71
        given
        report - BS C_Z51
        given exploration -1
        report - BS C_Z61
        given)"},
      {"exploration: each type, zone and rotation may be reported: fourteen points in 21 entries",
       R"(exploration
        report - BS C-BS
        report - CS C-CS1
        report - CS C-CS2
        report - RS C-RS1
        report - RS C-RS2
        report - SS C-SS
        report - DS C-DS
        given
        report C-BS RIGHT -
        report C-CS1 RIGHT -
        report C-CS2 RIGHT -
        report C-RS1 RIGHT -
        report C-RS2 RIGHT -
        report C-SS RIGHT -
        report C-DS RIGHT -
        report C-BS - RIGHT
        report C-CS1 - RIGHT
        report C-CS2 - RIGHT
        report C-RS1 - RIGHT
        report C-RS2 - RIGHT
        report C-SS - RIGHT
        report C-DS - RIGHT
        points exploration 14
        C-DS {order_id: 1} -> 202)",
       kBox},
      {"exploration: fourteen entries of a team, also when they are of types",
       R"(exploration
        report - BS C-BS
        report - CS C-CS1
        report - CS C-CS2
        report - RS C-RS1
        report - RS C-RS2
        report - SS C-SS
        report - DS C-DS
        report C-BS RIGHT -
        report C-CS1 RIGHT -
        report C-CS2 RIGHT -
        report C-RS1 RIGHT -
        report C-RS2 RIGHT -
        report C-SS RIGHT -
        report C-DS RIGHT -
        points exploration 7
        report C-DS - RIGHT
        points exploration 7)",
       kBook},
      {"exploration: a wrong entry of a type uses up a machine of that type",
       R"(exploration
        report - BS C_Z51
        report C-BS RIGHT RIGHT
        given exploration -1
        told {"event": "report", "machine": "C-BS", "judged": false}
        C-BS {side: OUTPUT, base_color: BASE_RED} -> 209
        report - CS C_Z51
        report C-CS2 RIGHT RIGHT
        report C-CS1 RIGHT RIGHT
        given exploration -1 exploration 1 exploration 1
        C-CS1 {operation: MOUNT_CAP} -> 209
        C-CS2 {operation: MOUNT_CAP} -> 103
        report C-DS RIGHT RIGHT
        given exploration 1 exploration 1)",
       kBox},
      {"exploration: a wrong entry of a type leaves its machines",
       R"(exploration
        report - BS C_Z51
        report C-BS RIGHT RIGHT
        given exploration -1 exploration 1 exploration 1
        C-BS {side: OUTPUT, base_color: BASE_RED} -> 0)",
       kBook},
      {"exploration: machines that were reported leave no entry of their type",
       R"(exploration
        report C-CS1 WRONG -
        report C-CS2 RIGHT RIGHT
        report - CS C_Z51
        given exploration -1 exploration 1 exploration 1
        told {"event": "report", "type": "CS", "judged": false}
        report - CS C-CS2
        told {"event": "report", "type": "CS", "judged": true}
        given)",
       kBox},
      {"exploration: machines that were reported leave entries of their type",
       R"(exploration
        report C-BS WRONG -
        report - BS C_Z51
        given exploration -1 exploration -1)",
       kBook},
      {"exploration: a type where the other team has such a machine is right, and uses up one of its own",
       R"(exploration
        report - SS M-SS
        given
        told {"event": "report", "type": "SS", "judged": true}
        wait 1.1
        message /machine_report_info /reported_types/0/name "M-SS"
        message /machine_report_info /reported_types/0/team_color "MAGENTA"
        report C-SS RIGHT RIGHT
        given
        report - RS M-RS1
        report C-RS1 RIGHT RIGHT
        report C-RS2 RIGHT RIGHT
        given exploration 1 exploration 1)",
       kBox},
      {"exploration: a type where the other team has such a machine is wrong",
       R"(exploration
        report - SS M-SS
        given exploration -1
        wait 1.1
        message /machine_report_info /reported_types/0/name ""
        message /machine_report_info /reported_types/0/team_color "")",
       kBook},
      {"exploration: a type where another machine stands is wrong",
       R"(exploration
        report - SS C-BS
        report - CS M-RS1
        given exploration -1 exploration -1)"},
      {"exploration: naming the other team's machine uses up one's own of that type",
       R"(exploration
        report M-BS RIGHT RIGHT
        told {"event": "report", "judged": false, "reason": "M-BS is not a machine of CYAN"}
        report C-BS RIGHT RIGHT
        given
        C-BS {side: OUTPUT, base_color: BASE_RED} -> 209
        report M-CS1 WRONG -
        report M-CS1 RIGHT -
        report C-CS1 RIGHT RIGHT
        report C-CS2 RIGHT RIGHT
        given exploration 1 exploration 1
        C-CS1 {operation: MOUNT_CAP} -> 103)",
       kBox},
      {"exploration: naming the other team's machine is ignored",
       R"(exploration
        report M-BS RIGHT RIGHT
        report C-BS RIGHT RIGHT
        given exploration 1 exploration 1)",
       kBook},
      {"exploration: a report in the other team's colour is denied",
       R"(exploration
        report C-BS RIGHT RIGHT as MAGENTA
        report - CS C_Z51 as MAGENTA
        given
        told {"event": "report", "judged": false, "reason": "found 'MAGENTA' as its team_color, expected CYAN"}
        report C-BS RIGHT RIGHT as CYAN
        given exploration 1 exploration 1)"},
      {"exploration: fourteen entries a team",
       R"(exploration
        report C-BS RIGHT -
        report C-CS1 RIGHT -
        report C-CS2 RIGHT -
        report C-RS1 RIGHT -
        report C-RS2 RIGHT -
        report C-SS RIGHT -
        report C-DS RIGHT -
        given exploration 1 exploration 1 exploration 1 exploration 1 exploration 1 exploration 1 exploration 1
        report C-BS - WRONG
        report C-CS1 - WRONG
        report C-CS2 - WRONG
        report C-RS1 - WRONG
        report C-RS2 - WRONG
        report C-SS - WRONG
        report C-DS - WRONG
        given exploration -1 exploration -1 exploration -1 exploration -1 exploration -1 exploration -1 exploration -1
        report - CS C_Z51
        given)",
       kBook},
      {"exploration: what is said again or makes no sense is none of the fourteen entries",
       R"(exploration
        report C-BS RIGHT -
        report C-BS RIGHT -
        report C-BS RIGHT -
        report C-BS RIGHT -
        report C-BS RIGHT -
        report C-BS RIGHT -
        report C-BS RIGHT -
        report C-BS RIGHT -
        report C-BS RIGHT -
        report C-XX RIGHT -
        report M-BS RIGHT -
        report - XX C_Z51
        report - CS C_Z99
        report C-CS1 NOWHERE -
        given exploration 1
        told {"event": "report", "judged": false, "reason": "no zone 'NOWHERE', they are C_Z11 to M_Z78"}
        report C-CS1 RIGHT RIGHT
        report C-DS RIGHT -
        given exploration 1 exploration 1 exploration 1)"},
      {"exploration: what is right is listed",
       R"(exploration
        report C-DS RIGHT RIGHT
        report C-SS RIGHT -
        wait 1.1
        message /machine_report_info /reported_machines ["C-DS"]
        message /machine_report_info /team_color "CYAN")"},
      {"exploration: after 180 s all machines are known, and reports are worth nothing",
       R"(exploration
        until 179.98
        C-BS {side: OUTPUT, base_color: BASE_RED} -> 209
        until 180.1
        C-BS {side: OUTPUT, base_color: BASE_RED} -> 0
        report C-BS RIGHT RIGHT
        given
        wait 2
        message /machine_info /machines/0/correctly_reported true)"},
      {"exploration: not in set-up",
       R"(exploration
        setup 10
        report C-BS RIGHT RIGHT
        given
        until 189
        C-BS {side: OUTPUT, base_color: BASE_RED} -> 209
        until 190.1
        C-BS {side: OUTPUT, base_color: BASE_RED} -> 0)"},
      {"exploration: lights of a machine that is not reported, half, wrong, right",
       R"(exploration
        lights C-BS OFF ON OFF
        report C-BS RIGHT -
        lights C-BS OFF BLINK OFF
        report C-BS - WRONG
        lights C-BS ON BLINK OFF
        report C-DS WRONG -
        lights C-DS ON ON OFF
        report C-SS RIGHT RIGHT
        lights C-SS OFF OFF ON
        until 180.1
        lights C-BS OFF OFF ON
        lights C-DS OFF OFF ON)"},
      {"exploration: a machine that is BROKEN shows the lights of its report until it is reported",
       R"(exploration
        C-BS {operation: RESET} -> 0
        C-BS is BROKEN
        lights C-BS OFF ON OFF
        report C-BS RIGHT -
        lights C-BS OFF BLINK OFF
        report C-BS - RIGHT
        wait 0.04
        lights C-BS BLINK BLINK OFF
        report C-DS WRONG -
        C-DS {operation: RESET} -> 0
        lights C-DS ON ON OFF
        until 31
        lights C-BS OFF OFF ON
        until 170
        C-DS {operation: RESET} -> 0
        lights C-DS ON ON OFF
        until 180.1
        lights C-DS BLINK BLINK OFF)",
       kBox},
      {"exploration: a machine that is DOWN shows the lights of its report until it is reported",
       R"(exploration
        down C-CS1 20
        wait 1
        C-CS1 is DOWN
        lights C-CS1 OFF ON OFF
        report C-CS1 RIGHT RIGHT
        wait 0.04
        lights C-CS1 ON OFF OFF)",
       kBox},
      {"exploration: a machine that is BROKEN shows that",
       R"(exploration
        C-BS {operation: RESET} -> 0
        lights C-BS BLINK BLINK OFF
        report C-BS RIGHT -
        lights C-BS BLINK BLINK OFF
        until 30.1
        lights C-BS OFF BLINK OFF)",
       kBook},
      {"exploration: a machine that was reset shows that in later phases of the game",
       R"(production 200
        overtime 0
        exploration
        until 190
        C-BS {operation: RESET} -> 0
        wait 0.04
        lights C-BS BLINK BLINK OFF
        until 200.1
        lights C-BS BLINK OFF OFF)"},
      {"exploration: payments count at once",
       R"(exploration
        hold BASE_RED
        put C-RS1-SLIDE
        wait 0.04
        points payment 2)"},

      {"information: the league sends a team its own machines without lights, payments, caps, poses",
       R"(information league
        hold BASE_RED
        put C-RS1-SLIDE
        wait 2.6
        message /machine_info /machines/6/name "C-DS"
        message /machine_info /machines/1/name "C-CS1"
        message /machine_info /machines/1/cap_color ""
        message /machine_info /machines/1/lights []
        message /machine_info /machines/1/pose {"x": 0.0, "y": 0.0, "theta": 0.0}
        message /machine_info /machines/3/loaded_with 0
        message /machine_info /machines/3/ring_colors ["RING_ORANGE", "RING_GREEN"]
        message /robot_info /robots/0/pose {"x": 0.0, "y": 0.0, "theta": 0.0})"},
      {"information: all of it",
       R"(information all
        hold BASE_RED
        put C-RS1-SLIDE
        wait 2.1
        message /machine_info /machines/13/name "M-DS"
        message /machine_info /machines/1/cap_color "CAP_GREY"
        message /machine_info /machines/3/loaded_with 1)"},
      {"information: markers, and the storage's filled slots",
       R"(information league
        C-SS {operation: CHANGE_INFO, shelf: 1, slot: 1, description: ours} -> 0
        wait 2.1
        message /machine_info /machines/0/input_tag 122
        message /machine_info /machines/0/output_tag 121
        message /machine_info /machines/2/input_tag 104
        message /machine_info /machines/3/input_tag 112
        message /machine_info /machines/4/output_tag 113
        message /machine_info /machines/5/input_tag 142
        message /machine_info /machines/6/output_tag 131
        message /machine_info /machines/5/status_ss/1 {"shelf": 1, "slot": 1, "is_filled": true, "description": "ours"}
        message /machine_info /machines/5/status_ss/5/shelf 5)"},
      {"information: magenta's markers are 100 more",
       R"(information league
        team MAGENTA
        wait 2.1
        message /machine_info /machines/1/name "M-CS1"
        message /machine_info /machines/1/input_tag 202)"},
      {"information: in exploration zones are heard of when they were reported",
       R"(information league
        exploration
        report C-BS RIGHT -
        wait 2.1
        message /machine_info /machines/0/zone ""
        message /machine_info /machines/0/rotation 0)"},
  };
  return kRows;
}

}  // namespace cxlab::rcll
