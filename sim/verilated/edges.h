// SPDX-License-Identifier: Apache-2.0
//
// Edges of `clk` for a Verilated top level that has no other clock, and nothing that waits for its fall.
// eval() does more around an edge than these small models do at one: messages, deleters, locks, and at
// the fall all that hangs on inputs once more.
//
//   WH_EDGES(Vwh_controller)  declares, for tops that eval() has seen once:
//   rise(top)   as `top.clk = 1; top.eval();`
//   again(top)  as rise(top) and fall(top), where no input has changed since the last rise(top): it saves
//               what hangs on inputs alone
//   fall(top)   as `top.clk = 0; top.eval();`, but for what an input changed since shows: that comes
//               with the next rise

#pragma once

#include "verilated.h"

// What Verilator keeps of the clock's level; where its name is another one, the fall is evaluated.
template <class Root>
bool forget_level(Root &root) {
    if constexpr (requires { root.__Vtrigprevexpr___TOP__clk__0; }) {
        root.__Vtrigprevexpr___TOP__clk__0 = 0;
        return true;
    } else {
        return false;
    }
}

// Evaluates what the only trigger there is, the clock's rise, changes; where Verilator has another name
// for it, nothing.
template <class Root>
bool evaluate_edge(Root &root, void (*triggered)(Root *)) {
    if constexpr (requires { root.__VnbaTriggered[0] = 1; }) {
        root.__VnbaTriggered[0] = 1;
        triggered(&root);
        root.__VnbaTriggered[0] = 0;
        return true;
    } else {
        return false;
    }
}

#define WH_EDGES(Top)                                       \
    void Top##___024root___eval(Top##___024root *);         \
    void Top##___024root___eval_nba(Top##___024root *);     \
    inline void rise(Top &top) {                            \
        top.clk = 1;                                        \
        Top##___024root___eval(top.rootp);                  \
    }                                                       \
    inline void fall(Top &top) {                            \
        top.clk = 0;                                        \
        if (!forget_level(*top.rootp)) Top##___024root___eval(top.rootp); \
    }                                                       \
    inline void again(Top &top) {                           \
        if (!evaluate_edge(*top.rootp, Top##___024root___eval_nba)) { \
            rise(top);                                      \
            fall(top);                                      \
        }                                                   \
    }
