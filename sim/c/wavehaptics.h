// SPDX-License-Identifier: Apache-2.0
//
// wavehaptics.h: a wave haptics controller on a serial line or on SPI: its words in their units, its arming, and an
// environment that a computer has. C99 and POSIX, and nothing else. docs/c.md tells how it is used. With
// WH_NO_SERIAL defined it needs C99's own library only: for a host MCU, whose program does the transfers.
//
// Every function that returns an int returns 0, or a negative enum wh_result; wh_message() then says in one
// line what is wrong and what would be right. A struct is the caller's own, and used by one thread at a time.

#ifndef WAVEHAPTICS_H
#define WAVEHAPTICS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "wavehaptics_words.h"

// The words of docs/words.md: WH_WORD_ROOT, WH_WORD_WALL_MIN, ...
enum wh_word {
#define WH_NAME(NAME, ...) WH_WORD_##NAME,
    WH_WORDS(WH_NAME)
#undef WH_NAME
        WH_WORD_COUNT
};

// Bits of the word `faults`: WH_FAULT_CURRENT, ...
enum wh_fault {
#define WH_BIT(bit, NAME, what) WH_FAULT_##NAME = 1 << (bit),
    WH_FAULTS(WH_BIT)
#undef WH_BIT
};

enum wh_result {
    WH_OK = 0,
    WH_PORT = -1,     // not there, no serial line, somebody else's, or gone
    WH_SILENT = -2,   // no answer, or none that fits the question, in time
    WH_DEVICE = -3,   // with another table of words, or made without what is asked for
    WH_REFUSED = -4,  // the device's own refusal
    WH_VALUE = -5,    // no such word, or out of its range
    WH_OFF = -6       // the bridges are off
};

struct wh_options {
    unsigned unit;     // 1...247; 0 is 1
    unsigned baud;     // bits a second from then on; 0: the fastest that device and port have
    double timeout_s;  // of an answer; 0 is 0.1 s. A simulated board needs more
};

// A device on SPI (docs/link.md), whose transfers the caller does: mode 0, most significant bit first.
struct wh_spi {
    // One transfer: CS low, `count` bytes each way at once, CS high. 0, or anything else where that failed.
    int (*transfer)(void *context, const uint8_t *out, uint8_t *in, size_t count);
    double (*now_s)(void *context);  // seconds of any clock that goes on
    void *context;
};

// What the device says of itself, `options` taken apart.
struct wh_identity {
    uint32_t words[12];
#define WH_FIELD(name, low, bits) unsigned name;
    WH_OPTIONS(WH_FIELD)
#undef WH_FIELD
};

enum { WH_IDENTITY_COUNT = 12, WH_MESSAGE = 256, WH_PATH = 128, WH_KEPT = 256 };

struct wh_board {
    struct wh_identity identity;

    // The library's own.
    char path[WH_PATH];
    char message[WH_MESSAGE];
    int file;          // -1: closed
    unsigned unit;
    unsigned rate;     // the word
    double timeout_s;
    double heard_s;    // when the last answer came
    double renewed_s;
    bool known;        // the identity is that of the device
    bool astray;       // answers to earlier questions may still come
    unsigned probes;
    size_t came;       // bytes that came to no answer
    uint8_t stop[13];  // the frame that disarms, for wh_stop
    struct wh_spi spi; // without a transfer: a serial line
    uint8_t kept[WH_KEPT];  // what came as questions went out
    size_t kept_count;
};

// Open the device at `path`, also a virtual board's, and hold it: a device with another table of words than
// wavehaptics_words.h is refused. `options` may be NULL. What is refused needs no wh_close.
// Not there with WH_NO_SERIAL.
int wh_open(struct wh_board *board, const char *path, const struct wh_options *options);
// The same of a device on SPI: `options` have no rate.
int wh_open_spi(struct wh_board *board, const struct wh_spi *spi, const struct wh_options *options);
// Give the port back. The bridges go off by themselves, 200 ms after the last renewal; wh_disarm is sooner.
void wh_close(struct wh_board *board);

// What was wrong last: one line without its end.
const char *wh_message(const struct wh_board *board);

// A word in its unit: of a motor where it is one's, and the index-th of several.
int wh_get(struct wh_board *board, enum wh_word word, unsigned motor, unsigned index, double *value);
int wh_set(struct wh_board *board, enum wh_word word, unsigned motor, unsigned index, double value);

// The bridges on for 200 ms, and again with each wh_renew; wh_exchange renews by itself.
int wh_arm(struct wh_board *board);
int wh_renew(struct wh_board *board);
// Off, once the device has said so.
int wh_disarm(struct wh_board *board);
// Off as far as a frame can, without waiting for an answer: may be called from a signal handler, or on SPI wherever
// a transfer may begin.
void wh_stop(const struct wh_board *board);

// What the guard latched, bits of enum wh_fault, and their meanings in words.
int wh_faults(struct wh_board *board, uint32_t *faults);
const char *wh_fault_text(uint32_t faults, char *text, size_t room);

// ---- Surfaces across the motors (docs/surfaces.md).

struct wh_surface_word {
    uint16_t address;  // row and word of rtl/wh_surface_words.v, 8 row + word
    int32_t word;
};

struct wh_surfaces {
    unsigned surfaces;  // that the device can have; 0: none
    unsigned acting;    // in contact
    bool pending;       // a frame is accepted, and applies with the next control period
    unsigned refused;   // 0: the last frame was accepted; else 128 and the row that was not
    unsigned stamp;     // of the last accepted frame
};

int wh_read_surfaces(struct wh_board *board, struct wh_surfaces *state);
// Write a frame of surfaces, all words of those that are there from now on: the device applies them together,
// or none. The components of a vector follow each other. `stamp`, 0...65535, should differ from that of the
// frame before. With `state`, which may be NULL, the device is asked: WH_REFUSED where it doesn't take the frame.
int wh_set_planes(struct wh_board *board, const struct wh_surface_word *words, size_t count, unsigned stamp,
                  struct wh_surfaces *state);

// Planes in metres about the tip of an arm, whose kinematics are the caller's.

enum { WH_SPACE_MOTORS = 3, WH_SPACE_PLANES = 8 };

struct wh_space_motor {
    double k_t;             // N·m/A, or V·s/rad
    double inductance;      // H
    double counts_per_rev;  // of the encoder, four a line
};

struct wh_space {
    struct wh_board *board;
    unsigned motors;    // 2 or 3
    double speed;       // m/s, the most with which a surface moves
    double angles[WH_SPACE_MOTORS];  // rad, in the middle of the count, as last read; 0 where encoders count 0

    // The library's own.
    double counts[WH_SPACE_MOTORS], count_rad[WH_SPACE_MOTORS], k_t[WH_SPACE_MOTORS];
    double damping[WH_SPACE_MOTORS];     // R̂/k_T²
    double compliance[WH_SPACE_MOTORS];  // L_eff/k_T²
    double tick_s;
    double delay_s;     // the longest from a wave v to its u
    unsigned planes;
};

struct wh_plane {
    double normal[3];   // out of the solid; its length is taken as 1
    double distance;    // m from the plane to the tip, above 0 outside of the solid
    double stiffness;   // N/m; 0: the largest that the motors have
    double loss;        // 0...1, part of the waves along the plane that is lost in a period
    double damping;     // N·s/m beside a stiffness; 0: that of the motors
};

// It sets `surface_budget`: moving surfaces give out 1 mJ beyond what they took, at most.
int wh_space_open(struct wh_space *space, struct wh_board *board, const struct wh_space_motor *motors,
                  unsigned count, double speed);
// Read the encoders into `angles`.
int wh_space_read(struct wh_space *space);
// Write planes about the tip, all there are from now on. `jacobian` in m/rad has a row for x, y and z and a
// column for a motor, at the `angles`. `stamp` and `state` are those of wh_set_planes.
int wh_space_planes(struct wh_space *space, double jacobian[3][WH_SPACE_MOTORS], const struct wh_plane *planes,
                    size_t count, unsigned stamp, struct wh_surfaces *state);
// Force of the motors on the hand at the tip, N, of their last currents: the least that is their torques, 0 at
// a singularity.
int wh_space_force(struct wh_space *space, double jacobian[3][WH_SPACE_MOTORS], double force[3]);

// ---- A motor's port.

struct wh_motor {
    double k_t;             // N·m/A, or V·s/rad
    double counts_per_rev;  // of the encoder, four a line
};

struct wh_port {
    struct wh_board *board;
    unsigned motor;
    double k_t;
    double count_rad;
    double s;           // √(2 R̂), √Ω
    double b;           // k_T²/R̂, N·m·s/rad
    double tick_s;
    double period_s;    // of a packet, without packets 0
    unsigned timeout;   // periods
    int sequence;       // of the newest packet, -1 before the first
    uint32_t packets;
    uint32_t missed;
};

struct wh_state {
    int32_t count;
    double x;          // rad, with an anchor finer than a count, else the middle of it
    double omega;      // rad/s: with an anchor over 256 ticks, else of one step
    double current;    // A
    double torque;     // N·m
    bool contact;      // in one of the device's own walls
    bool saturated;
    bool anchor_fault;
    double contact_energy;  // J, delivered to the shaft by the contact, or by the last one; brushless: 0
};

struct wh_packet {
    uint8_t sequence;
    unsigned periods;  // since the packet before: 1, and one more for each that was missed
    double v;          // √W, mean over its period
    bool active;       // the host's answers are in force
};

int wh_port_open(struct wh_port *port, struct wh_board *board, unsigned motor,
                 const struct wh_motor *data);
int wh_read_state(struct wh_port *port, struct wh_state *state);

// Wait for a packet newer than the last one. WH_OFF where the bridges are off.
int wh_next(struct wh_port *port, struct wh_packet *packet);
// Answer the last packet with u, √W, and wait for the next. Both go in one piece; 20 times a second a
// renewal of the arming goes along.
int wh_exchange(struct wh_port *port, double u, struct wh_packet *packet);

// Speed that a packet and a torque on the rotor mean together, rad/s:
//   k_T ω = s v + R̂ τ / k_T,   ω = s v / k_T + τ / b
double wh_speed(const struct wh_port *port, double v, double torque);
// The answer that makes that torque: u = v + s τ / k_T.
double wh_wave(const struct wh_port *port, double v, double torque);

#endif
