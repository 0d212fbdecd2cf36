// SPDX-License-Identifier: Apache-2.0
//
// C interface to the Verilated wh_linked_device, at its SPI: whole transfers, as a host MCU does them, and the clocks
// that they take.

#include <cstdint>

#include "Vwh_linked_device.h"
#include "ends.h"
#include "verilated.h"

namespace {

struct Device {
    VerilatedContext context;
    Vwh_linked_device top{&context};
    int64_t clocks = 0;
    int64_t half = 3;  // clocks of half a bit
    double clock_hz = 1;

    ~Device() { ends(context); }
};

void wait(Device *device, int64_t clocks) {
    auto &top = device->top;
    for (int64_t n = 0; n < clocks; ++n) {
        top.clk = 1;
        top.eval();
        top.clk = 0;
        top.eval();
    }
    device->clocks += clocks;
}

}  // namespace

extern "C" {

void *wh_spi_new(double clock_hz) {
    auto *device = new Device;
    auto &top = device->top;
    device->clock_hz = clock_hz;
    top.uart_rx_i = 1;
    top.spi_cs_n_i = 1;
    top.stop_i = 1;
    top.driver_fault_i = 7;
    top.rst = 1;
    wait(device, 4);
    top.rst = 0;
    wait(device, 20000);  // until its defaults are applied
    return device;
}

void wh_spi_delete(void *model) { delete static_cast<Device *>(model); }

// Clocks of half a bit from now on.
void wh_spi_half(void *model, int64_t clocks) { static_cast<Device *>(model)->half = clocks; }

int64_t wh_spi_clocks(void *model) { return static_cast<Device *>(model)->clocks; }

void wh_spi_wait(void *model, int64_t clocks) { wait(static_cast<Device *>(model), clocks); }

double wh_spi_now_s(void *model) {
    const auto *device = static_cast<Device *>(model);
    return device->clocks / device->clock_hz;
}

int wh_spi_transfer(void *model, const uint8_t *out, uint8_t *in, size_t count) {
    auto *device = static_cast<Device *>(model);
    auto &top = device->top;
    top.spi_cs_n_i = 0;
    wait(device, 6);
    for (size_t n = 0; n < count; ++n) {
        int got = 0;
        for (int place = 7; place >= 0; --place) {
            top.spi_mosi_i = out[n] >> place & 1;
            wait(device, device->half);
            got = got << 1 | top.spi_miso_o;
            top.spi_sclk_i = 1;
            wait(device, device->half);
            top.spi_sclk_i = 0;
        }
        in[n] = static_cast<uint8_t>(got);
    }
    wait(device, 3);
    top.spi_cs_n_i = 1;
    wait(device, 8);
    return 0;
}
}
