// SPDX-License-Identifier: Apache-2.0
//
// Calls of sim/c/wavehaptics.h, a line each from the standard input, and what they come to on the standard
// output: "0 ..." or the negative result and its message. For test_c_library.py.

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "wavehaptics.h"

static const char *const names[] = {
#define WH_NAME(NAME, ...) #NAME,
    WH_WORDS(WH_NAME)
#undef WH_NAME
};

static unsigned word_of(const char *name) {
    for (unsigned n = 0; n < WH_WORD_COUNT; ++n) {
        if (strcmp(names[n], name) == 0) return n;
    }
    return WH_WORD_COUNT;
}

int main(void) {
    static struct wh_board board;
    static struct wh_port port;
    static struct wh_space space;
    struct wh_packet packet = {0};
    char line[16384];
    while (fgets(line, sizeof line, stdin)) {
        char name[16] = "", word[200] = "", told[400] = "";
        unsigned a = 0, b = 0;
        double value = 0.0;
        int result = 0;
        (void)sscanf(line, "%15s", name);
        if (strcmp(name, "open") == 0) {
            struct wh_options options = {0};
            if (sscanf(line, "%*s %199s %u %u %lf", word, &options.unit, &options.baud, &options.timeout_s) < 1) break;
            result = wh_open(&board, word, &options);
        } else if (strcmp(name, "get") == 0) {
            (void)sscanf(line, "%*s %199s %u %u", word, &a, &b);
            result = wh_get(&board, (enum wh_word)word_of(word), a, b, &value);
            (void)snprintf(told, sizeof told, "%.12g", value);
        } else if (strcmp(name, "set") == 0) {
            (void)sscanf(line, "%*s %199s %u %u %lf", word, &a, &b, &value);
            result = wh_set(&board, (enum wh_word)word_of(word), a, b, value);
        } else if (strcmp(name, "arm") == 0) {
            result = wh_arm(&board);
        } else if (strcmp(name, "renew") == 0) {
            result = wh_renew(&board);
        } else if (strcmp(name, "disarm") == 0) {
            result = wh_disarm(&board);
        } else if (strcmp(name, "stop") == 0) {
            wh_stop(&board);
        } else if (strcmp(name, "faults") == 0) {
            uint32_t faults = 0;
            result = wh_faults(&board, &faults);
            (void)wh_fault_text(faults, told, sizeof told);
        } else if (strcmp(name, "port") == 0) {
            struct wh_motor motor = {0};
            (void)sscanf(line, "%*s %u %lf %lf", &a, &motor.k_t, &motor.counts_per_rev);
            result = wh_port_open(&port, &board, a, &motor);
            (void)snprintf(told, sizeof told, "%.12g %.12g %.12g %u", port.s, port.b, port.period_s, port.timeout);
        } else if (strcmp(name, "state") == 0) {
            struct wh_state state = {0};
            result = wh_read_state(&port, &state);
            (void)snprintf(told, sizeof told, "%ld %.12g %.12g %.12g %d %.12g", (long)state.count, state.x, state.omega,
                           state.torque, state.contact, state.contact_energy);
        } else if (strcmp(name, "next") == 0) {
            result = wh_next(&port, &packet);
            (void)snprintf(told, sizeof told, "%u %u %.12g %d", packet.sequence, packet.periods, packet.v, packet.active);
        } else if (strcmp(name, "exchange") == 0) {
            (void)sscanf(line, "%*s %lf", &value);
            result = wh_exchange(&port, value, &packet);
            (void)snprintf(told, sizeof told, "%u %u %.12g %d", packet.sequence, packet.periods, packet.v, packet.active);
        } else if (strcmp(name, "steal") == 0) {  // the largest wave each time, with the sign that helps the motion
            (void)sscanf(line, "%*s %u", &a);
            result = wh_next(&port, &packet);
            for (unsigned n = 0; n < a && !result; ++n) result = wh_exchange(&port, packet.v >= 0.0 ? 127.0 : -127.0, &packet);
        } else if (strcmp(name, "planes") == 0) {  // stamp, and address=word of each word
            static struct wh_surface_word words[700];
            struct wh_surfaces state = {0};
            size_t count = 0;
            (void)sscanf(line, "%*s %u", &a);
            for (const char *at = line; count < 700 && (at = strchr(at, '=')); ++at) {
                const char *first = at;
                while (first[-1] != ' ') --first;
                words[count].address = (uint16_t)strtoul(first, NULL, 10);
                words[count++].word = (int32_t)strtol(at + 1, NULL, 10);
            }
            result = wh_set_planes(&board, words, count, a, &state);
            (void)snprintf(told, sizeof told, "%u %u %d %u %u", state.surfaces, state.acting, state.pending, state.refused,
                           state.stamp);
        } else if (strcmp(name, "space") == 0) {  // motors, speed, k_t, inductance and counts_per_rev of all
            static struct wh_space_motor motors[3];
            (void)sscanf(line, "%*s %u %lf %lf %lf %lf", &a, &value, &motors[0].k_t, &motors[0].inductance,
                         &motors[0].counts_per_rev);
            motors[1] = motors[2] = motors[0];
            result = wh_space_open(&space, &board, motors, a, value);
            (void)snprintf(told, sizeof told, "%.12g %.12g %.12g", space.angles[0], space.angles[1], space.angles[2]);
        } else if (strcmp(name, "solid") == 0) {  // stamp, nine of the Jacobian, and seven of each plane
            static struct wh_plane planes[9];
            double jacobian[3][3], of[9 * 7] = {0}, force[3] = {0};
            char *at = line + 5;
            size_t count = 0;
            a = (unsigned)strtoul(at, &at, 10);
            for (unsigned n = 0; n < 9; ++n) jacobian[n / 3][n % 3] = strtod(at, &at);
            for (char *next = at; count < 63 && (of[count] = strtod(at, &next), next != at); at = next) ++count;
            for (size_t n = 0; n < count / 7; ++n) {
                memcpy(planes[n].normal, of + 7 * n, sizeof planes[n].normal);
                planes[n].distance = of[7 * n + 3];
                planes[n].stiffness = of[7 * n + 4];
                planes[n].loss = of[7 * n + 5];
                planes[n].damping = of[7 * n + 6];
            }
            result = wh_space_planes(&space, jacobian, planes, count / 7, a, NULL);
            if (!result) result = wh_space_force(&space, jacobian, force);
            (void)snprintf(told, sizeof told, "%.12g %.12g %.12g", force[0], force[1], force[2]);
        } else if (strcmp(name, "close") == 0) {
            wh_close(&board);
        } else {
            break;
        }
        if (result) (void)snprintf(told, sizeof told, "%s", wh_message(&board));
        printf("%d %s\n", result, told);
        (void)fflush(stdout);
    }
    return 0;
}
