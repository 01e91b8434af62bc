// The referee: deliveries and their points. Begun quarters of the window cost 18.75 % each, begun fifths 15 % each;
// whole points, cut off.

#include "rules_table.h"

namespace cxlab::rcll {

std::span<const Row> delivery_rows() {
  static const Row kRows[] = {
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
      {"delivery: the cap of a surplus product counts that was made after a stored one was delivered, once",
       R"(order C0 BASE_RED CAP_GREY
        C-SS {operation: RETRIEVE, shelf: 0, slot: 1} -> 0
        take C-SS-OUTPUT
        put C-DS-INPUT
        C-DS {order_id: 1} -> 0
        verdict correct
        lay BASE_CLEAR CAP_GREY at C-CS1-INPUT
        C-CS1 {operation: RETRIEVE_CAP} -> 0
        remove C-CS1
        wait 6
        lay BASE_RED at C-CS1-INPUT
        C-CS1 {operation: MOUNT_CAP} -> 0
        take C-CS1-OUTPUT
        put C-DS-INPUT
        given penalty -5 delivery 20 cap 10 buffer 2
        C-DS {order_id: 1} -> 0
        verdict surplus
        given cap 10
        told {"event": "delivery", "order": 1, "correct": false, "points": 10, "reason": "surplus"}
        wait 6
        lay BASE_CLEAR CAP_GREY at C-CS1-INPUT
        C-CS1 {operation: RETRIEVE_CAP} -> 0
        remove C-CS1
        wait 6
        lay BASE_RED at C-CS1-INPUT
        C-CS1 {operation: MOUNT_CAP} -> 0
        take C-CS1-OUTPUT
        put C-DS-INPUT
        C-DS {order_id: 1} -> 0
        verdict surplus
        given buffer 2)",
       kBox},
      {"delivery: no points for a surplus product that was made before a stored one was delivered",
       R"(order C0 BASE_RED CAP_GREY
        lay BASE_CLEAR CAP_GREY at C-CS1-INPUT
        C-CS1 {operation: RETRIEVE_CAP} -> 0
        remove C-CS1
        wait 6
        lay BASE_RED at C-CS1-INPUT
        C-CS1 {operation: MOUNT_CAP} -> 0
        C-SS {operation: RETRIEVE, shelf: 0, slot: 1} -> 0
        take C-SS-OUTPUT
        put C-DS-INPUT
        C-DS {order_id: 1} -> 0
        wait 6
        take C-CS1-OUTPUT
        put C-DS-INPUT
        C-DS {order_id: 1} -> 0
        verdict surplus
        given buffer 2 penalty -5 delivery 20 cap 10)"},
      {"delivery: no points for a surplus product that was not made, or another than the order asks for",
       R"(order C0 BASE_RED CAP_GREY
        C-SS {operation: RETRIEVE, shelf: 0, slot: 1} -> 0
        take C-SS-OUTPUT
        put C-DS-INPUT
        C-DS {order_id: 1} -> 0
        wait 6
        lay BASE_RED CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        verdict surplus
        lay BASE_CLEAR CAP_GREY at C-CS1-INPUT
        C-CS1 {operation: RETRIEVE_CAP} -> 0
        remove C-CS1
        wait 6
        lay BASE_BLACK at C-CS1-INPUT
        C-CS1 {operation: MOUNT_CAP} -> 0
        take C-CS1-OUTPUT
        put C-DS-INPUT
        C-DS {order_id: 1} -> 0
        verdict wrong product
        given penalty -5 delivery 20 cap 10 buffer 2)"},
      {"delivery: no points for a surplus product after a stored one",
       R"(order C0 BASE_RED CAP_GREY
        C-SS {operation: RETRIEVE, shelf: 0, slot: 1} -> 0
        take C-SS-OUTPUT
        put C-DS-INPUT
        C-DS {order_id: 1} -> 0
        lay BASE_CLEAR CAP_GREY at C-CS1-INPUT
        C-CS1 {operation: RETRIEVE_CAP} -> 0
        remove C-CS1
        wait 6
        lay BASE_RED at C-CS1-INPUT
        C-CS1 {operation: MOUNT_CAP} -> 0
        take C-CS1-OUTPUT
        put C-DS-INPUT
        C-DS {order_id: 1} -> 0
        verdict surplus
        given penalty -5 delivery 20 cap 10 buffer 2)",
       kBook},
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
        points delivery 20 cap 10 late -15 competitive -5)",
       kBook},
      {"points: the second with a competitive order loses 10 however late it is",
       R"(order C0 BASE_RED CAP_GREY competitive window 0 20
        lay BASE_RED CAP_GREY at M-DS-INPUT
        rival M-DS {order_id: 1}
        until 60
        lay BASE_RED CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        points delivery 20 cap 10 late -15 competitive -10)",
       kBox},
      {"points: one C0 a game of those that lay in the storage at its beginning",
       R"(order C0 BASE_RED CAP_GREY
        order C0 BASE_RED CAP_BLACK quantity 2
        C-SS {operation: RETRIEVE, shelf: 0, slot: 1} -> 0
        take C-SS-OUTPUT
        put C-DS-INPUT
        C-DS {order_id: 1} -> 0
        verdict correct
        wait 6
        C-SS {operation: RETRIEVE, shelf: 1, slot: 1} -> 0
        take C-SS-OUTPUT
        put C-DS-INPUT
        C-DS {order_id: 2} -> 0
        verdict another from the storage
        wait 6
        lay BASE_RED CAP_BLACK at C-DS-INPUT
        C-DS {order_id: 2} -> 0
        verdict correct)",
       kBook},
      {"points: what lay in the storage is so after it was there once more",
       R"(order C0 BASE_RED CAP_GREY
        order C0 BASE_RED CAP_BLACK
        C-SS {operation: RETRIEVE, shelf: 0, slot: 1} -> 0
        take C-SS-OUTPUT
        put C-DS-INPUT
        C-DS {order_id: 1} -> 0
        verdict correct
        wait 6
        C-SS {operation: RETRIEVE, shelf: 1, slot: 1} -> 0
        take C-SS-OUTPUT
        wait 6
        put C-SS-INPUT
        C-SS {operation: STORE, shelf: 1, slot: 1} -> 0
        wait 6
        C-SS {operation: RETRIEVE, shelf: 1, slot: 1} -> 0
        take C-SS-OUTPUT
        put C-DS-INPUT
        C-DS {order_id: 2} -> 0
        verdict another from the storage)",
       kBook},
      {"points: what the team has stored itself counts as any other product",
       R"(order C0 BASE_RED CAP_GREY quantity 2
        C-SS {operation: RETRIEVE, shelf: 0, slot: 1} -> 0
        take C-SS-OUTPUT
        put C-DS-INPUT
        C-DS {order_id: 1} -> 0
        wait 6
        lay BASE_RED CAP_GREY at C-SS-INPUT
        C-SS {operation: STORE, shelf: 0, slot: 1} -> 0
        wait 6
        C-SS {operation: RETRIEVE, shelf: 0, slot: 1} -> 0
        take C-SS-OUTPUT
        put C-DS-INPUT
        C-DS {order_id: 1} -> 0
        verdict correct
        points delivery 40 cap 20 penalty -15)"},
      {"points: the order of overtime is not served from the storage",
       R"(production 100
        lay BASE_RED CAP_GREY at C-DS-INPUT
        lay BASE_RED CAP_GREY at M-DS-INPUT
        C-DS {order_id: 1} -> 0
        rival M-DS {order_id: 1}
        until 101
        message /order_info /orders/1/base_color "BASE_BLACK"
        message /order_info /orders/1/cap_color "CAP_GREY"
        C-SS {operation: RETRIEVE, shelf: 4, slot: 1} -> 0
        take C-SS-OUTPUT
        put C-DS-INPUT
        C-DS {order_id: 2} -> 0
        verdict from the storage in overtime)",
       kBook},
      {"points: from the storage as many as are there",
       R"(order C0 BASE_RED CAP_GREY quantity 2
        C-SS {operation: RETRIEVE, shelf: 0, slot: 1} -> 0
        take C-SS-OUTPUT
        put C-DS-INPUT
        C-DS {order_id: 1} -> 0
        wait 6
        lay BASE_RED CAP_GREY at C-SS-INPUT
        C-SS {operation: STORE, shelf: 0, slot: 1} -> 0
        wait 6
        C-SS {operation: RETRIEVE, shelf: 0, slot: 1} -> 0
        take C-SS-OUTPUT
        put C-DS-INPUT
        C-DS {order_id: 1} -> 0
        verdict correct
        points delivery 40 cap 20 penalty -15)",
       kBox},
      {"points: only the first product of a competitive order",
       R"(order C0 BASE_RED CAP_GREY competitive quantity 2
        lay BASE_RED CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        wait 6
        lay BASE_RED CAP_GREY at C-DS-INPUT
        C-DS {order_id: 1} -> 0
        points delivery 40 cap 20 competitive 10)"},

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
  return kRows;
}

}  // namespace cxlab::rcll
