// The rules of the league, a row each: machines (what they accept, their states, how long they work, payments, what
// breaks them, lights), then the game (phases, orders, deliveries, points). Rows without a name of rules hold under all
// three; where referee box and rulebook differ there is a row for each. `league` follows the referee box here. What
// this release does not have (mounting of rings, storage, exploration, overtime, maintenance) has no row.
//
// Prices of rings at seed 1: ORANGE 0, YELLOW 0, BLUE 1, GREEN 2.

#include "game_script.h"

namespace cxlab::rcll {
namespace {

struct Row {
  const char* rule;  ///< its place in the rules, and the rule
  const char* script;
  const char* under = "league refbox rulebook";
};

// A referee box that scores as the league does, and the rulebook.
constexpr const char* kBox = "league refbox";
constexpr const char* kBook = "rulebook";

const Row kRows[] = {
    // --- Instructions
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
    {"instructions: RETRIEVE_CAP while a cap is buffered breaks a cap station",
     R"(lay BASE_CLEAR CAP_GREY at C-CS1-INPUT
        C-CS1 {operation: RETRIEVE_CAP} -> 0
        take C-CS1-OUTPUT
        wait 6
        loaded C-CS1 1
        C-CS1 {operation: RETRIEVE_CAP} -> 103
        C-CS1 is BROKEN
        loaded C-CS1 0
        wait 0
        points)"},
    {"instructions: MOUNT_CAP while no cap is buffered breaks a cap station",
     R"(C-CS1 {operation: MOUNT_CAP} -> 103
        C-CS1 is BROKEN)"},
    {"instructions: a delivery station breaks on an order that does not exist",
     R"(C-DS {order_id: 2} -> 103
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

    // A second instruction.
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

    // --- States
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

    // --- Durations
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

    // --- Down
    {"down: an idle machine is idle again afterwards",
     R"(down C-RS1 30
        wait 0.02
        C-RS1 is DOWN
        wait 29.9
        C-RS1 is DOWN
        wait 0.2
        C-RS1 is IDLE)"},
    {"down: 50 s while PREPARED, and the work takes 50 s longer",
     R"(lay BASE_CLEAR CAP_GREY at C-CS1-INPUT
        C-CS1 {operation: RETRIEVE_CAP}
        wait 1
        down C-CS1 50
        wait 1
        C-CS1 is DOWN
        ends 0 after 71.694)"},
    {"down: 50 s while PROCESSING, and the work takes 50 s longer",
     R"(lay BASE_CLEAR CAP_GREY at C-CS1-INPUT
        C-CS1 {operation: RETRIEVE_CAP}
        wait 12
        down C-CS1 50
        wait 49
        C-CS1 is DOWN
        wait 2
        C-CS1 is PROCESSING
        ends 0 after 71.694)"},
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
        at C-CS1-OUTPUT BASE_CLEAR)"},
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

    // --- Payments
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

    // --- Caps
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
    {"down: a machine that is BROKEN stays so",
     R"(C-BS {operation: RESET} -> 0
        wait 1
        down C-BS 10
        wait 1
        C-BS is BROKEN
        wait 27.5
        C-BS is BROKEN
        wait 1
        C-BS is IDLE)"},
    {"breaking: what lies on other machines stays there",
     R"(lay BASE_RED at C-CS1-INPUT
        lay BASE_BLACK at C-BS-OUTPUT
        C-BS {operation: RESET} -> 0
        at C-CS1-INPUT BASE_RED
        at C-BS-OUTPUT nothing)"},

    // --- What breaks a machine
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

    // --- Lights: red, yellow, green
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
        C-CS1 {operation: RETRIEVE_CAP}
        until 10.1
        lights C-BS BLINK OFF OFF
        lights C-CS1 BLINK OFF OFF)"},

    // --- Phases
    {"phases: set-up, production, the end; each begins its time anew",
     R"(setup 10
        production 20
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
        until 8
        C-BS {side: OUTPUT, base_color: BASE_RED}
        until 30
        C-BS is PROCESSED
        at C-BS-OUTPUT nothing)"},

    // --- Orders
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

    // --- Deliveries
    {"delivery: a wrong base counts nothing",
     R"(lay BASE_SILVER CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        verdict wrong product
        points)"},
    {"delivery: a wrong cap counts nothing",
     R"(lay BASE_RED CAP_BLACK at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        verdict wrong product
        points)"},
    {"delivery: a product without its cap counts nothing",
     R"(lay BASE_RED at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        verdict wrong product
        points)"},
    {"delivery: a missing ring counts nothing",
     R"(order C2 BASE_RED RING_BLUE RING_GREEN CAP_GREY
        lay BASE_RED RING_BLUE CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        verdict wrong product
        points)"},
    {"delivery: a ring too many counts nothing",
     R"(lay BASE_RED RING_BLUE CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        verdict wrong product
        points)"},
    {"delivery: a ring of another colour counts nothing",
     R"(order C1 BASE_RED RING_BLUE CAP_GREY
        lay BASE_RED RING_GREEN CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        verdict wrong product
        points)"},
    {"delivery: rings in the other order count nothing",
     R"(order C2 BASE_RED RING_BLUE RING_GREEN CAP_GREY
        lay BASE_RED RING_GREEN RING_BLUE CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        verdict wrong product
        points)"},
    {"delivery: a third ring of another colour counts nothing",
     R"(order C3 BASE_RED RING_BLUE RING_GREEN RING_BLUE CAP_GREY
        lay BASE_RED RING_BLUE RING_GREEN RING_YELLOW CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        verdict wrong product
        points)"},
    {"delivery: more than the quantity counts nothing",
     R"(lay BASE_RED CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        points delivery 20 cap 10
        wait 6
        lay BASE_RED CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        verdict surplus
        points delivery 20 cap 10)"},
    {"delivery: each product of the quantity counts",
     R"(order C0 BASE_RED CAP_GREY quantity 2
        lay BASE_RED CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        wait 6
        lay BASE_RED CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        verdict correct
        points delivery 40 cap 20)"},
    {"delivery: for the order that was named, whatever fits better",
     R"(order C0 BASE_RED CAP_GREY
        order C0 BASE_BLACK CAP_GREY
        lay BASE_RED CAP_GREY at C-DS-INPUT
        C-DS {order_id: 2} -> 0
        verdict wrong product
        points)"},
    {"delivery: of the other team is its own",
     R"(lay BASE_RED CAP_GREY at M-DS-INPUT
        rival M-DS {order_id: 1}
        wait 6
        verdict correct
        points
        rival points delivery 20 cap 10
        lay BASE_RED CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        verdict correct
        points delivery 20 cap 10)"},
    {"delivery: half a product scores nothing",
     R"(order C1 BASE_RED RING_GREEN CAP_GREY
        lay BASE_RED RING_GREEN at C-CS1-OUTPUT
        take C-CS1-OUTPUT
        put C-DS-INPUT
        C-DS {order_id: 0} -> 0
        points)"},

    // --- Points
    {"points: C0 20, cap 10",
     R"(lay BASE_RED CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        late 0
        points delivery 20 cap 10
        message /game_state /points_cyan 30
        message /game_state /points_magenta 0)"},
    {"points: C1 30, a ring of price 0 5",
     R"(order C1 BASE_RED RING_ORANGE CAP_GREY
        lay BASE_RED RING_ORANGE CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        points delivery 30 ring 5 cap 10)"},
    {"points: a ring of price 1 10",
     R"(order C1 BASE_RED RING_BLUE CAP_GREY
        lay BASE_RED RING_BLUE CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        points delivery 30 ring 10 cap 10)"},
    {"points: a ring of price 2 20",
     R"(order C1 BASE_RED RING_GREEN CAP_GREY
        lay BASE_RED RING_GREEN CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        points delivery 30 ring 20 cap 10)"},
    {"points: C2 50, two rings",
     R"(order C2 BASE_BLACK RING_GREEN RING_YELLOW CAP_BLACK
        lay BASE_BLACK RING_GREEN RING_YELLOW CAP_BLACK at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        points delivery 50 ring 25 cap 10)"},
    {"points: C3 100, three rings",
     R"(order C3 BASE_SILVER RING_BLUE RING_GREEN RING_BLUE CAP_BLACK
        lay BASE_SILVER RING_BLUE RING_GREEN RING_BLUE CAP_BLACK at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        points delivery 100 ring 40 cap 10)"},
    {"points: the first with a competitive order gets 10 more",
     R"(order C0 BASE_RED CAP_GREY competitive
        lay BASE_RED CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        points delivery 20 cap 10 competitive 10)"},
    {"points: the second with a competitive order loses 10",
     R"(order C0 BASE_RED CAP_GREY competitive
        lay BASE_RED CAP_GREY at M-DS-INPUT
        rival M-DS {order_id: 1}
        wait 6
        rival points delivery 20 cap 10 competitive 10
        lay BASE_RED CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        points delivery 20 cap 10 competitive -10)"},
    {"points: the second with a competitive order loses no more than its late delivery is worth",
     R"(order C0 BASE_RED CAP_GREY competitive window 0 20
        lay BASE_RED CAP_GREY at M-DS-INPUT
        rival M-DS {order_id: 1}
        until 60
        lay BASE_RED CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        points delivery 20 cap 10 late -15 competitive -5)"},
    {"points: only the first product of a competitive order",
     R"(order C0 BASE_RED CAP_GREY competitive quantity 2
        lay BASE_RED CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        wait 6
        lay BASE_RED CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        points delivery 40 cap 20 competitive 10)"},

    // --- Lateness: begun quarters of the window cost 18.75 % each, begun fifths 15 % each; whole points, cut off
    {"late: in the first quarter C0 loses 3",
     R"(order C0 BASE_RED CAP_GREY window 0 100
        until 110
        lay BASE_RED CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        late 13.8
        points delivery 20 cap 10 late -3)"},
    {"late: in the second quarter C0 loses 7",
     R"(order C0 BASE_RED CAP_GREY window 0 100
        until 140
        lay BASE_RED CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        points delivery 20 cap 10 late -7)",
     kBox},
    {"late: in the third fifth C0 loses 9",
     R"(order C0 BASE_RED CAP_GREY window 0 100
        until 140
        lay BASE_RED CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        points delivery 20 cap 10 late -9)",
     kBook},
    {"late: in the third quarter C1 loses 16",
     R"(order C1 BASE_RED RING_ORANGE CAP_GREY window 100 200
        until 250
        lay BASE_RED RING_ORANGE CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        points delivery 30 ring 5 cap 10 late -16)",
     kBox},
    {"late: in the third fifth C1 loses 13",
     R"(order C1 BASE_RED RING_ORANGE CAP_GREY window 100 200
        until 250
        lay BASE_RED RING_ORANGE CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        points delivery 30 ring 5 cap 10 late -13)",
     kBook},
    {"late: in the last quarter C2 loses 37, rings and cap count in full",
     R"(order C2 BASE_BLACK RING_GREEN RING_YELLOW CAP_BLACK window 0 100
        until 180
        lay BASE_BLACK RING_GREEN RING_YELLOW CAP_BLACK at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        points delivery 50 ring 25 cap 10 late -37)"},
    {"late: never more than three quarters",
     R"(order C3 BASE_SILVER RING_BLUE RING_GREEN RING_BLUE CAP_BLACK window 0 10
        until 600
        lay BASE_SILVER RING_BLUE RING_GREEN RING_BLUE CAP_BLACK at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        points delivery 100 ring 40 cap 10 late -75)"},
    {"late: what counts is the end of the delivery, not its begin",
     R"(order C0 BASE_RED CAP_GREY window 0 100
        until 99
        lay BASE_RED CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        late 2.8
        points delivery 20 cap 10 late -3)"},
};

struct Case {
  const Row* row;
  std::string rules;
};

std::vector<Case> cases() {
  std::vector<Case> all;
  for (const Row& row : kRows) {
    std::istringstream in(row.under);
    for (std::string rules; in >> rules;) all.push_back({&row, rules});
  }
  return all;
}

void PrintTo(const Case& c, std::ostream* out) { *out << c.row->rule << ", rules: " << c.rules; }

class Rules : public testing::TestWithParam<Case> {};

TEST_P(Rules, Hold) {
  WorldConfig config;
  config.rules = GetParam().rules;
  GameScript().play(GetParam().row->script, config);
}

INSTANTIATE_TEST_SUITE_P(Table, Rules, testing::ValuesIn(cases()), [](const auto& row) {
  std::string name = std::string(row.param.row->rule) + " " + row.param.rules;
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  return name;
});

}  // namespace
}  // namespace cxlab::rcll
