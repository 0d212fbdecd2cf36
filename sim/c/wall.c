// SPDX-License-Identifier: Apache-2.0
//
// wall: a wall of a spring and a damper that this computer renders, packet by packet.
//
//   wall PORT [-k N·m/rad] [-b N·m·s/rad] [-x rad] [-m k_T] [-c counts] [-n packets] [-r baud] [-t seconds]
//
// A packet's v is taken apart into the speed that a torque goes with, and the torque is that of the wall, both
// at the period's end (backward Euler, so that the spring gives back no more than went into it):
//
//   k_T ω = s v + R̂ τ/k_T     τ = −K (x + T ω) − B ω     u = v + s τ/k_T     x += T ω
//
// where x is the depth; a wall doesn't pull, and outside of it τ = 0. What comes of lost packets or of a host
// that hangs is the device's business: it gives out no energy that it hasn't taken in. x is counted along by
// ω, and set to the encoder's in free space, where that moves no torque.

#define _DEFAULT_SOURCE
#define _DARWIN_C_SOURCE

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "wavehaptics.h"

enum { LOOK_PACKETS = 16, MOST_PERIODS = 8, MOST_BAD = 5 };

static struct wh_board board;
static volatile sig_atomic_t asked_to_stop;

static void stop(int number) {
    asked_to_stop = number;
    wh_stop(&board);
}

struct wall {
    double stiffness, damping;  // N·m/rad, N·m·s/rad
    double depth;               // rad, above 0 in the wall
};

// The torque on the rotor over a time step, in which the depth goes on.
static double wall_step(struct wall *wall, const struct wh_port *port, double v, double step_s) {
    const double free = wh_speed(port, v, 0.0);
    const double speed = (free - wall->stiffness * wall->depth / port->b) /
                         (1.0 + (wall->stiffness * step_s + wall->damping) / port->b);
    const double depth = wall->depth + step_s * speed;
    const double torque = -wall->stiffness * depth - wall->damping * speed;
    if (depth > 0.0 && torque < 0.0) {
        wall->depth = depth;
        return torque;
    }
    wall->depth += step_s * free;
    return 0.0;
}

static int serve(struct wall *wall, struct wh_port *port, double place, unsigned long packets) {
    struct wh_state state = {0};
    struct wh_packet packet = {0};
    double deepest = 0.0;
    int result = wh_read_state(port, &state);
    if (!result) result = wh_arm(port->board);
    if (!result) result = wh_next(port, &packet);
    wall->depth = state.x - place;
    while (!result && !asked_to_stop && (packets == 0 || port->packets < packets)) {
        const unsigned periods = packet.periods < MOST_PERIODS ? packet.periods : MOST_PERIODS;
        const double torque = wall_step(wall, port, packet.v, periods * port->period_s);
        if (wall->depth > deepest) deepest = wall->depth;
        result = wh_exchange(port, wh_wave(port, packet.v, torque), &packet);
        // On a bad line the wall goes on with the packet that comes next.
        for (int bad = 0; result == WH_SILENT && bad < MOST_BAD && !asked_to_stop; ++bad) {
            result = wh_next(port, &packet);
        }
        if (!result && torque == 0.0 && port->packets % LOOK_PACKETS == 0) {
            result = wh_read_state(port, &state);
            wall->depth = state.x - place;
        }
    }
    printf("%lu packets, %lu missed, deepest %.3g rad\n", (unsigned long)port->packets,
           (unsigned long)port->missed, deepest);
    return asked_to_stop ? 0 : result;
}

static double number(const char *option, const char *text) {
    char *end;
    const double value = strtod(text, &end);
    if (*text && *end == '\0' && value >= -1e9 && value <= 1e9) return value;
    fprintf(stderr, "wall: -%s %s is no number\n", option, text);
    exit(2);
}

int main(int count, char **words) {
    struct wall wall = {.stiffness = 0.5, .damping = 1e-3};
    struct wh_motor motor = {.k_t = 60.3e-3, .counts_per_rev = 10000.0};
    struct wh_options options = {0};
    double place = 0.0, packets = 0.0;
    for (int option; (option = getopt(count, words, "k:b:x:m:c:n:r:t:")) != -1;) {
        const char name[2] = {(char)option, '\0'};
        if (option == '?') return 2;
        const double value = number(name, optarg);
        switch (option) {
            case 'k': wall.stiffness = value; break;
            case 'b': wall.damping = value; break;
            case 'x': place = value; break;
            case 'm': motor.k_t = value; break;
            case 'c': motor.counts_per_rev = value; break;
            case 'n': packets = value; break;
            case 'r': options.baud = value > 0.0 ? (unsigned)value : 0; break;
            default: options.timeout_s = value; break;
        }
    }
    if (optind + 1 != count || !(wall.stiffness >= 0.0 && wall.damping >= 0.0 && packets >= 0.0)) {
        fprintf(stderr, "wall: give one port, and no number below 0 but -x: wall PORT [-k N·m/rad] [-b N·m·s/rad] "
                        "[-x rad] [-m N·m/A] [-c counts] [-n packets] [-r baud] [-t s]\n");
        return 2;
    }
    struct wh_port port;
    int result = wh_open(&board, words[optind], &options);
    if (!result) {
        const struct sigaction action = {.sa_handler = stop};
        (void)sigaction(SIGINT, &action, NULL);
        (void)sigaction(SIGTERM, &action, NULL);
        result = wh_port_open(&port, &board, 0, &motor);
        if (!result) result = serve(&wall, &port, place, (unsigned long)packets);
        if (result) {
            wh_stop(&board);
        } else {
            result = wh_disarm(&board);
        }
    }
    if (result) fprintf(stderr, "wall: %s\n", wh_message(&board));
    wh_close(&board);
    return result ? 2 : 0;
}
