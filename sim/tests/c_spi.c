// SPDX-License-Identifier: Apache-2.0
//
// A host MCU's program: examples/c/sphere.c over SPI, on the RTL (sim/verilated/spi_shim.cpp). For test_c_spi.py.

#include <stdio.h>
#include <stdlib.h>

#include "sphere.h"

void *wh_spi_new(double clock_hz);
void wh_spi_delete(void *model);
void wh_spi_half(void *model, int64_t clocks);
int64_t wh_spi_clocks(void *model);
void wh_spi_wait(void *model, int64_t clocks);
double wh_spi_now_s(void *model);
int wh_spi_transfer(void *model, const uint8_t *out, uint8_t *in, size_t count);

static int64_t bytes;
static int break_in;  // transfers until one loses a bit; 0: none does

static int transfer(void *model, const uint8_t *out, uint8_t *in, size_t count) {
    uint8_t sent[300];
    for (size_t n = 0; n < count; ++n) sent[n] = out[n];
    if (break_in && --break_in == 0) sent[count / 2] ^= 4;
    bytes += (int64_t)count;
    return wh_spi_transfer(model, sent, in, count);
}

static int set(struct wh_board *board, enum wh_word word, double value) {
    return wh_set(board, word, 0, 0, value);
}

int main(int count, char **words) {
    static struct wh_board board;
    struct wh_space space;
    struct sphere sphere;
    double root = 0.0;
    if (count != 4) return 2;
    const double clock_hz = strtod(words[1], NULL);
    void *const model = wh_spi_new(clock_hz);
    const struct wh_spi spi = {.transfer = transfer, .now_s = wh_spi_now_s, .context = model};
    wh_spi_half(model, strtol(words[2], NULL, 10));
    const struct wh_options options = {.timeout_s = 2e-3};
    int result = wh_open_spi(&board, &spi, &options);
    if (!result) result = set(&board, WH_WORD_HALF_CLOCKS, 104);
    if (!result) result = set(&board, WH_WORD_TICK_HALVES, 4);
    if (!result) result = set(&board, WH_WORD_EXTRA_TICKS, 1);
    for (unsigned n = 0; !result && n < 3; ++n) {
        result = wh_set(&board, WH_WORD_ROOT, n, 0, 2.0);
        if (!result) result = wh_set(&board, WH_WORD_A, n, 0, 0.01);
    }
    if (!result) result = wh_get(&board, WH_WORD_ROOT, 2, 0, &root);
    if (!result) result = sphere_open(&sphere, &space, &board, 0.005);
    const int64_t begun = wh_spi_clocks(model), before = bytes;
    const unsigned long updates = strtoul(words[3], NULL, 10);
    while (!result && sphere.updates < updates) result = sphere_update(&sphere, &space);
    const int64_t clocks = wh_spi_clocks(model) - begun, moved = bytes - before;
    struct wh_surfaces state = {0};
    if (!result) result = wh_read_surfaces(&board, &state);
    if (!result && state.stamp != updates - 1) result = 1;
    for (int n = 1; !result && n < 6; ++n) {  // a bit is lost in one of its transfers: asked again
        break_in = n;
        result = sphere_update(&sphere, &space);
    }
    break_in = 0;
    if (!result) result = wh_read_surfaces(&board, &state);
    if (result) printf("%d %s\n", result, wh_message(&board));
    else printf("0 %.17g %lld %lld %u %lu\n", root, (long long)clocks, (long long)moved, state.stamp, sphere.updates);
    wh_close(&board);
    wh_spi_delete(model);
    return result != 0;
}
