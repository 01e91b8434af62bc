// Maintenance of robots: what begins and ends it, what it costs, how long it may last.

#include "rules_table.h"

namespace cxlab::rcll {

std::span<const Row> maintenance_rows() {
  static const Row kRows[] = {
      {"maintenance: a team asks for it, and the robot leaves the field",
       R"(maintenance 2
        robot 2 at 5.5 -0.6
        robot 1 at 4.5 0.5
        told {"event": "maintenance", "state": "begin", "team": "CYAN", "robot": "robot2", "cause": "request", "cycle": 1}
        message /robot_info /robots/1/state "MAINTENANCE"
        message /robot_info /robots/1/maintenance_cycles 1
        message /robot_info /robots/0/state "ACTIVE")"},
      {"maintenance: a team that hears what the league says is told too",
       R"(information league
        fault 10 1 60
        until 25.1
        message /robot_info /robots/0/state "MAINTENANCE"
        message /robot_info /robots/0/maintenance_time_remaining 105.0
        message /robot_info /robots/1/maintenance_time_remaining 0.0)"},
      {"maintenance: the first is free, the second costs 5 points",
       R"(repair 0
        maintenance 1
        points
        maintenance 1 ends
        wait 1
        maintenance 1
        points penalty -5
        given penalty -5)"},
      {"maintenance: each robot has two",
       R"(repair 0
        maintenance 1
        maintenance 1 ends
        wait 1
        maintenance 2
        maintenance 2 ends
        wait 1
        maintenance 3
        points)"},
      {"maintenance: the third disqualifies the robot",
       R"(repair 0
        maintenance 1
        maintenance 1 ends
        wait 1
        maintenance 1
        maintenance 1 ends
        wait 1
        robot 1 at 4.5 0.5
        maintenance 1
        told {"event": "maintenance", "state": "disqualified", "robot": "robot1", "cause": "request"}
        message /robot_info /robots/0/state "DISQUALIFIED"
        message /robot_info /robots/0/maintenance_cycles 2
        robot 1 at 4.5 -0.6
        points penalty -5
        maintenance 1 ends
        wait 1
        told {"event": "maintenance", "state": "refused", "number": 1, "reason": "disqualified"}
        wait 200
        robot 1 at 4.5 -0.6)"},
      {"maintenance: a team that asked for it must ask for its end",
       R"(maintenance 1
        wait 100
        robot 1 at 4.5 -0.6
        maintenance 1 ends
        robot 1 at 4.5 0.5
        message /robot_info /robots/0/state "ACTIVE")"},
      {"maintenance: its end must be asked for again the second time, of which the team is warned as well",
       R"(maintenance 1
        wait 106
        maintenance 1 ends
        wait 1
        message /robot_info /robots/0/state "ACTIVE"
        maintenance 1
        wait 60
        message /robot_info /robots/0/state "MAINTENANCE"
        wait 46
        told {"event": "maintenance", "state": "warning"}
        maintenance 1 ends
        wait 1
        message /robot_info /robots/0/state "ACTIVE")"},
      {"maintenance: people need their time for the robot",
       R"(maintenance 1
        maintenance 1 ends
        wait 29.9
        robot 1 at 4.5 -0.6
        wait 0.1
        robot 1 at 4.5 0.5
        told {"event": "maintenance", "state": "end", "robot": "robot1", "duration_s": 30.0})"},
      {"maintenance: it lasts a second at least",
       R"(repair 0
        maintenance 1
        maintenance 1 ends
        robot 1 at 4.5 -0.6
        wait 0.9
        robot 1 at 4.5 -0.6
        wait 0.1
        robot 1 at 4.5 0.5)"},
      {"maintenance: after 105 s the team is warned",
       R"(maintenance 1
        wait 104.9
        told {"event": "maintenance", "state": "begin"}
        wait 0.1
        told {"event": "maintenance", "state": "warning", "robot": "robot1", "remaining_s": 15.0}
        message /robot_info /robots/0/state "MAINTENANCE")"},
      {"maintenance: within the grace after 120 s it may still come back",
       R"(maintenance 1
        wait 134.8
        maintenance 1 ends
        robot 1 at 4.5 0.5
        message /robot_info /robots/0/state "ACTIVE")"},
      {"maintenance: longer than 135 s disqualifies the robot",
       R"(maintenance 1
        wait 134.9
        message /robot_info /robots/0/state "MAINTENANCE"
        wait 0.1
        told {"event": "maintenance", "state": "disqualified", "robot": "robot1", "cause": "time"}
        message /robot_info /robots/0/state "DISQUALIFIED"
        maintenance 1 ends
        told {"event": "maintenance", "state": "refused", "reason": "disqualified"}
        robot 1 at 4.5 -0.6)"},
      {"maintenance: the carried workpiece is removed, and that is no drop",
       R"(hold BASE_RED
        robot 1 holds BASE_RED
        maintenance 1
        robot 1 holds nothing
        told {"event": "piece", "from": "gripper", "from_name": "robot1", "to": "crew"}
        points)"},
      {"maintenance: a fault begins it, and it ends when people are done",
       R"(fault 10 2 40
        until 9.98
        robot 2 at 5.5 0.5
        until 10
        told {"event": "maintenance", "state": "begin", "robot": "robot2", "cause": "fault"}
        robot 2 at 5.5 -0.6
        until 49.96
        robot 2 at 5.5 -0.6
        until 50
        robot 2 at 5.5 0.5)"},
      {"maintenance: people who need too long disqualify the robot",
       R"(fault 10 2 136
        until 144.9
        message /robot_info /robots/1/state "MAINTENANCE"
        until 145
        message /robot_info /robots/1/state "DISQUALIFIED")"},
      {"maintenance: 135 s are just in time",
       R"(fault 10 2 135
        until 145.02
        message /robot_info /robots/1/state "ACTIVE")"},
      {"maintenance: a fault during another maintenance waits until the robot is back",
       R"(fault 10 1 40
        fault 20 1 30
        until 49.9
        message /robot_info /robots/0/maintenance_cycles 1
        until 50.1
        message /robot_info /robots/0/state "MAINTENANCE"
        message /robot_info /robots/0/maintenance_cycles 2
        points penalty -5)"},
      {"maintenance: not before production",
       R"(setup 5
        fault 2 2 40
        maintenance 1
        told {"event": "maintenance", "state": "refused", "team": "CYAN", "number": 1, "reason": "not in production"}
        until 4.9
        message /robot_info /robots/1/state "ACTIVE"
        until 5.1
        message /robot_info /robots/1/state "MAINTENANCE")"},
      {"maintenance: of the team's own robots",
       R"(maintenance 1 of MAGENTA
        told {"event": "maintenance", "state": "refused", "reason": "not the team's own robot"}
        maintenance 4
        told {"event": "maintenance", "state": "refused", "number": 4, "reason": "no such robot"}
        robot 1 at 4.5 0.5)"},
      {"maintenance: asking twice changes nothing",
       R"(maintenance 1 ends
        told {"event": "maintenance", "state": "refused", "reason": "not in maintenance"}
        maintenance 1
        wait 1
        maintenance 1
        told {"event": "maintenance", "state": "refused", "reason": "in maintenance"}
        message /robot_info /robots/0/maintenance_cycles 1
        points)"},
      {"maintenance: a base that is fully outside of the field",
       R"(robot 1 to 4.5 8.2
        wait 0.1
        robot 1 at 4.5 8.2
        robot 1 to 4.5 8.23
        told {"event": "maintenance", "state": "begin", "robot": "robot1", "cause": "outside"}
        wait 29.9
        robot 1 at 4.5 -0.6
        wait 0.1
        robot 1 at 4.5 0.5)"},
      {"maintenance: outside on each side",
       R"(robot 1 to 7.23 5
        robot 2 to -7.23 5
        robot 3 to 3 -0.23
        message /robot_info /robots/0/state "MAINTENANCE"
        message /robot_info /robots/1/state "MAINTENANCE"
        message /robot_info /robots/2/state "MAINTENANCE"
        points)"},
      {"maintenance: who finds its place taken comes back at another one of its team",
       R"(fault 10 1 40
        until 20
        robot 2 to 4.0 0.5
        until 50.1
        robot 1 at 5.5 0.5)"},
      {"maintenance: a place is taken up to 0.75 m around it",
       R"(fault 10 1 40
        fault 10 2 40
        until 20
        robot 3 to 5.24 0.5
        until 50.1
        robot 1 at 6.5 0.5
        robot 2 at 5.5 -0.6
        robot 3 to 4.74 0.5
        wait 0.6
        robot 2 at 5.5 0.5)"},
      {"maintenance: who finds all places taken waits, and is not disqualified for that",
       R"(fault 10 1 134
        fault 10 2 134
        until 20
        robot 3 to 5.0 0.5
        until 144.1
        robot 1 at 6.5 0.5
        robot 2 at 5.5 -0.6
        until 160
        message /robot_info /robots/1/state "MAINTENANCE"
        robot 3 to 4 4
        wait 0.6
        robot 2 at 5.5 0.5)"},
  };
  return kRows;
}

}  // namespace cxlab::rcll
