// SPDX-License-Identifier: Apache-2.0
//
// A ball that a PHANTOM's tip can touch: the loop of a haptic device's driver, on sim/c. It reads the motors' angles,
// computes the tip and the plane that touches the ball next to it, sends that plane, and reads the force. The device
// renders the plane at its own rate, so this loop may be slow or irregular.
//
//   cc -Isim/c -Iexamples/c sim/c/wavehaptics.c examples/c/sphere.c -lm -o sphere && ./sphere /dev/ttyUSB0
//
// On a host MCU compile with -DWH_NO_SERIAL, and call sphere_open and sphere_update with a board of wh_open_spi.

#include "sphere.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double radius = 0.02;  // m
static const double stiffness = 2000.0;  // N/m
static const double fastest = 0.5;  // m/s, of the plane
static const double ratio = 8.0, link_m = 0.14;

// RE 25 118743 with an encoder of 2,500 lines, as in boards/ulx3s_space/board.toml.
static const struct wh_space_motor motor = {.k_t = 23.4e-3, .inductance = 0.24e-3, .counts_per_rev = 10000.0};

static double centre[3];

// A PHANTOM of two equal links, whose angles are the motors' behind a gear; all 0 where it was switched on.
static void tip_of(const double *angles, double tip[3]) {
    const double a = angles[0] / ratio, b = angles[1] / ratio, c = angles[2] / ratio;
    const double out = link_m * (cos(b) + sin(c));
    tip[0] = out * sin(a);
    tip[1] = link_m * (1.0 - cos(c) + sin(b));
    tip[2] = out * cos(a) - link_m;
}

static void jacobian_of(const double *angles, double jacobian[3][WH_SPACE_MOTORS]) {
    const double a = angles[0] / ratio, b = angles[1] / ratio, c = angles[2] / ratio;
    const double out = link_m * (cos(b) + sin(c)) / ratio, unit = link_m / ratio;
    const double rows[3][WH_SPACE_MOTORS] = {
        {out * cos(a), -unit * sin(b) * sin(a), unit * cos(c) * sin(a)},
        {0.0, unit * cos(b), unit * sin(c)},
        {-out * sin(a), -unit * sin(b) * cos(a), unit * cos(c) * cos(a)},
    };
    memcpy(jacobian, rows, sizeof rows);
}

int sphere_open(struct sphere *sphere, struct wh_space *space, struct wh_board *board, double gap) {
    const struct wh_space_motor motors[WH_SPACE_MOTORS] = {motor, motor, motor};
    memset(sphere, 0, sizeof *sphere);
    const int result = wh_space_open(space, board, motors, WH_SPACE_MOTORS, fastest);
    if (result) return result;
    tip_of(space->angles, centre);
    centre[2] += radius + gap;  // in front of the tip
    return WH_OK;
}

int sphere_update(struct sphere *sphere, struct wh_space *space) {
    struct wh_plane plane = {.stiffness = stiffness};
    double jacobian[3][WH_SPACE_MOTORS], square = 0.0;
    int result = wh_space_read(space);
    if (result) return result;
    tip_of(space->angles, sphere->tip);
    jacobian_of(space->angles, jacobian);
    for (unsigned n = 0; n < 3; ++n) {
        plane.normal[n] = sphere->tip[n] - centre[n];
        square += plane.normal[n] * plane.normal[n];
    }
    if (!(square > 0.0)) plane.normal[2] = -1.0;  // in the very middle every direction is out
    plane.distance = sqrt(square) - radius;
    if (-plane.distance > sphere->depth) sphere->depth = -plane.distance;
    result = wh_space_planes(space, jacobian, &plane, 1, (unsigned)(sphere->updates & 0xffff), NULL);
    if (!result) result = wh_space_force(space, jacobian, sphere->force);
    if (!result) ++sphere->updates;
    return result;
}

#ifndef WH_NO_SERIAL

#include <signal.h>

static volatile sig_atomic_t ends;

static void end(int number) {
    (void)number;
    ends = 1;
}

int main(int count, char **words) {
    static struct wh_board board;
    struct wh_space space;
    struct sphere sphere;
    const unsigned long most = count > 2 ? strtoul(words[2], NULL, 10) : 0;
    const double gap = count > 3 ? strtod(words[3], NULL) : 0.005;
    const struct wh_options options = {.timeout_s = count > 4 ? strtod(words[4], NULL) : 0.0};
    if (count < 2 || count > 5) {
        fprintf(stderr, "sphere: give PORT [UPDATES [GAP [TIMEOUT]]], such as /dev/ttyUSB0 1000 0.005\n");
        return 2;
    }
    (void)signal(SIGINT, end);
    int result = wh_open(&board, words[1], &options);
    if (!result) result = sphere_open(&sphere, &space, &board, gap);
    if (!result) result = wh_arm(&board);
    while (!result && !ends && (most == 0 || sphere.updates < most)) {
        result = sphere_update(&sphere, &space);
        if (!result) result = wh_renew(&board);
    }
    if (result) {
        fprintf(stderr, "%s\n", wh_message(&board));
        wh_stop(&board);
    } else {
        result = wh_disarm(&board);
        printf("%lu updates, deepest %.2f mm, force %.2f N\n", sphere.updates, 1e3 * sphere.depth,
               sqrt(sphere.force[0] * sphere.force[0] + sphere.force[1] * sphere.force[1] +
                    sphere.force[2] * sphere.force[2]));
    }
    wh_close(&board);
    return result ? 2 : 0;
}

#endif
