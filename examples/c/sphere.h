// SPDX-License-Identifier: Apache-2.0

#ifndef SPHERE_H
#define SPHERE_H

#include "wavehaptics.h"

// What the loop has met.
struct sphere {
    unsigned long updates;
    double tip[3];    // m
    double depth;     // m, the deepest that the tip was inside
    double force[3];  // N, last
};

// Prepare three motors and put the ball beside the tip: its distance from it in m, outside above 0.
int sphere_open(struct sphere *sphere, struct wh_space *space, struct wh_board *board, double gap);
// One update: the angles are read, the plane that touches the ball next to the tip is sent, the force is read.
int sphere_update(struct sphere *sphere, struct wh_space *space);

#endif
