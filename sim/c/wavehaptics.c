// SPDX-License-Identifier: Apache-2.0
//
// wavehaptics.c: what wavehaptics.h declares.
//
// Questions are frames of Modbus RTU, functions 3 and 16 (docs/link.md). Several go out in one piece and are
// answered in their order. An answer tells neither which question it is to nor, of a read, which words it has:
// so once one is late, broken or doesn't fit, nothing more is believed until the line is settled. That is
// done by a question whose answer is like no other, the identification at another length than the last time;
// what comes before it is thrown away. On SPI the device has no turn of its own: what is to be read is clocked with
// FILLER, which begins no question, and zeros come where no answer waits.

#define _DEFAULT_SOURCE  // flock, and rates beyond POSIX's
#define _DARWIN_C_SOURCE

#include "wavehaptics.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#ifndef WH_NO_SERIAL
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/file.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>
#endif

enum {
    READ = 3,
    WRITE = 16,
    REFUSES = 0x80,
    ANSWER_MOST = 5 + 4 * WH_MOST_READ,
    QUESTIONS_MOST = 256,
    WRITE_MOST = 53,  // words
    TRIES = 4,       // of questions, where the line can be settled in between
    SETTLES = 3,     // in a row, until it is taken for silent
    NONE_LEFT = 1,
    FILLER = 0xff,
    FILLERS = 64     // in a transfer, at most
};

enum kind { WH_SETTING, WH_COMMAND, WH_LIVE, WH_MEMORY };
enum copies { WH_OF_BOARD, WH_OF_MOTOR, WH_OF_WALL, WH_OF_SECTION };

#define WH_BY_DELAY (-1.0)

static const struct row {
    const char *name;
    uint16_t address;
    enum kind kind;
    enum copies of;
    unsigned count;
    unsigned fraction;
    bool has_sign;
    double low, high;
    const char *unit;
} rows[] = {
#define WH_ROW(NAME, name, address, kind, of, count, fraction, has_sign, low, high, unit) \
    {name, address, kind, of, count, fraction, has_sign, low, high, unit},
    WH_WORDS(WH_ROW)
#undef WH_ROW
};

static const unsigned rates[] = {
#define WH_RATE(rate) rate,
    WH_RATES(WH_RATE)
#undef WH_RATE
};

enum { RATES = sizeof rates / sizeof *rates };

enum {
#define WH_PLACE(NAME) ID_##NAME,
    WH_IDENTIFICATION(WH_PLACE)
#undef WH_PLACE
        ID_COUNT
};

// The struct has room for as many.
typedef char identity_is_whole[(int)ID_COUNT == (int)WH_IDENTITY_COUNT ? 1 : -1];

static const double fallback_s = 1.2;   // a device without a good frame is at its first rate again
static const double silence_s = 0.05;   // nothing is under way, also through a bridge that waits 16 ms
static const double spi_silence_s = 2e-3;
static const double renewal_s = 0.05;
static const double arming_s = 10.0;    // for a simulated board's zero as well
static const double babble_s = 1.0;     // after which a line that is never silent is asked all the same

// ---- Messages.

#ifdef __GNUC__
__attribute__((format(printf, 3, 4)))
#endif
static int fail(struct wh_board *board, enum wh_result result, const char *format, ...) {
    va_list values;
    va_start(values, format);
    (void)vsnprintf(board->message, sizeof board->message, format, values);
    va_end(values);
    return result;
}

const char *wh_message(const struct wh_board *board) { return board->message; }

static int silent(struct wh_board *board) {
    if (board->spi.transfer) {
        return fail(board, WH_SILENT,
                    "SPI: no answer with a right CRC within %g s; are all four wires right, SCLK at most a sixth of "
                    "the device's clock, its unit %u, and its parameter SPI 1?",
                    board->timeout_s, board->unit);
    }
    if (board->came) {
        return fail(board, WH_SILENT,
                    "%s: %zu bytes came, but no answer with a right CRC; is it unit %u, at %u bits a "
                    "second, and nobody else on the line?",
                    board->path, board->came, board->unit, rates[board->rate]);
    }
    return fail(board, WH_SILENT,
                "%s: no answer within %g s; is it the right port, the device on and of unit %u? A "
                "simulated one may need a longer time",
                board->path, board->timeout_s, board->unit);
}

// Append to a text that is cut where the room ends.
static void append(char *text, size_t room, const char *before, const char *more) {
    const size_t length = strlen(text);
    if (length + 1 < room) (void)snprintf(text + length, room - length, "%s%s", before, more);
}

// ---- The line.

static bool on_spi(const struct wh_board *board) { return board->spi.transfer != NULL; }

static int exchange(struct wh_board *board, const uint8_t *out, uint8_t *in, size_t count) {
    if (board->spi.transfer(board->spi.context, out, in, count) == 0) return WH_OK;
    return fail(board, WH_PORT, "%s: a transfer has failed; is the bus set up, and not in use?", board->path);
}

static int send_on_spi(struct wh_board *board, const uint8_t *bytes, size_t count) {
    if (board->kept_count + count > sizeof board->kept) board->kept_count = 0;  // of earlier questions
    const int result = exchange(board, bytes, board->kept + board->kept_count, count);
    if (!result) board->kept_count += count;
    return result;
}

// What waits, `room` bytes at most, or 0 where nothing has come until the time is over. It begins without zeros
// where it is to begin an answer.
static int receive_on_spi(struct wh_board *board, uint8_t *bytes, size_t room, bool begins, double until) {
    uint8_t filler[FILLERS];
    memset(filler, FILLER, sizeof filler);
    for (;;) {
        size_t count = board->kept_count < room ? board->kept_count : room, zeros = 0;
        if (count) {
            memcpy(bytes, board->kept, count);
            memmove(board->kept, board->kept + count, board->kept_count - count);
            board->kept_count -= count;
        } else {
            if (board->spi.now_s(board->spi.context) >= until) return 0;
            count = room < FILLERS ? room : FILLERS;
            const int result = exchange(board, filler, bytes, count);
            if (result) return result;
        }
        while (begins && zeros < count && bytes[zeros] == 0) ++zeros;
        if (zeros == count) continue;
        memmove(bytes, bytes + zeros, count - zeros);
        return (int)(count - zeros);
    }
}

#ifdef WH_NO_SERIAL

static double now_s(const struct wh_board *board) { return board->spi.now_s(board->spi.context); }

static int send_bytes(struct wh_board *board, const uint8_t *bytes, size_t count) {
    return send_on_spi(board, bytes, count);
}

static int receive(struct wh_board *board, uint8_t *bytes, size_t room, bool begins, double until) {
    return receive_on_spi(board, bytes, room, begins, until);
}

#else

static int gone(struct wh_board *board) {
    const char *reason = errno ? strerror(errno) : "the line has ended";
    return fail(board, WH_PORT, "%s: %s; was it unplugged?", board->path, reason);
}

static double now_s(const struct wh_board *board) {
    struct timespec now;
    if (on_spi(board)) return board->spi.now_s(board->spi.context);
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

// Wait until the port has bytes, or room for some; 0 where the time is over.
static int await(const struct wh_board *board, short events, double until) {
    const double left = until - now_s(board);
    struct pollfd port = {.fd = board->file, .events = events};
    const int found = poll(&port, 1, left <= 0.0 ? 0 : left > 1e3 ? 1000000 : (int)(1e3 * left) + 1);
    return found < 0 && errno == EINTR ? 1 : found;
}

static int send_bytes(struct wh_board *board, const uint8_t *bytes, size_t count) {
    if (on_spi(board)) return send_on_spi(board, bytes, count);
    const double until = now_s(board) + board->timeout_s;
    while (count) {
        const ssize_t sent = write(board->file, bytes, count);
        if (sent > 0) {
            bytes += sent;
            count -= (size_t)sent;
        } else if (sent < 0 && errno != EAGAIN && errno != EINTR) {
            return gone(board);
        } else if (await(board, POLLOUT, until) == 0) {
            return fail(board, WH_SILENT, "%s: takes no bytes within %g s", board->path,
                        board->timeout_s);
        }
    }
    return WH_OK;
}

// Bytes that come, `room` at most: their number, 0 where the time is over, or an enum wh_result.
static int receive(struct wh_board *board, uint8_t *bytes, size_t room, bool begins, double until) {
    if (on_spi(board)) return receive_on_spi(board, bytes, room, begins, until);
    for (;;) {
        const int there = await(board, POLLIN, until);
        if (there == 0) return 0;
        errno = 0;
        const ssize_t count = there < 0 ? -1 : read(board->file, bytes, room);
        if (count > 0) return (int)count;
        if (count == 0 || (errno != EAGAIN && errno != EINTR)) return gone(board);
        if (now_s(board) >= until) return 0;
    }
}

#endif

static uint16_t crc_of(const uint8_t *bytes, size_t count) {
    unsigned crc = 0xffff;
    for (size_t n = 0; n < count; ++n) {
        crc ^= bytes[n];
        for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xa001u : 0u);
    }
    return (uint16_t)crc;
}

static bool sealed(const uint8_t *frame, size_t length) {
    const uint16_t crc = crc_of(frame, length - 2);
    return frame[length - 2] == (crc & 0xff) && frame[length - 1] == crc >> 8;
}

// ---- Questions.

struct question {
    uint8_t function;
    uint16_t at;          // register
    unsigned count;       // words
    uint32_t words[WRITE_MOST];  // to be written
    uint32_t *found;      // those that were read
    const char *what;
};

static uint16_t word_register(unsigned address) {
    return (uint16_t)(WH_TABLE_REGISTER + 2 * address);
}

static uint8_t *put16(uint8_t *at, unsigned value) {
    *at++ = (uint8_t)(value >> 8);
    *at++ = (uint8_t)value;
    return at;
}

static size_t frame_of(uint8_t *frame, unsigned unit, const struct question *asked) {
    uint8_t *at = frame;
    *at++ = (uint8_t)unit;
    *at++ = asked->function;
    at = put16(at, asked->at);
    at = put16(at, 2 * asked->count);
    if (asked->function == WRITE) {
        *at++ = (uint8_t)(4 * asked->count);
        for (unsigned n = 0; n < asked->count; ++n) {
            at = put16(at, asked->words[n] >> 16);
            at = put16(at, asked->words[n] & 0xffff);
        }
    }
    const uint16_t crc = crc_of(frame, (size_t)(at - frame));
    *at++ = (uint8_t)crc;
    *at++ = (uint8_t)(crc >> 8);
    return (size_t)(at - frame);
}

// Length of what begins as the answer to a question, or as its refusal; 0 where it is neither.
static size_t length_of(const uint8_t *bytes, size_t count, unsigned unit,
                        const struct question *asked) {
    if ((count > 0 && bytes[0] != unit) || (count > 1 && (bytes[1] & ~REFUSES) != asked->function)) return 0;
    if (count > 1 && bytes[1] & REFUSES) return 5;
    if (asked->function == READ) {
        if (count > 2 && bytes[2] != 4 * asked->count) return 0;
        return 5 + 4 * asked->count;
    }
    uint8_t echo[4];
    put16(put16(echo, asked->at), 2 * asked->count);
    for (size_t n = 2; n < count && n < 6; ++n) {
        if (bytes[n] != echo[n - 2]) return 0;
    }
    return 8;
}

// Throw away what comes until the line is silent, or has babbled for long.
static int drain(struct wh_board *board) {
    uint8_t bytes[ANSWER_MOST];
    const double end = now_s(board) + babble_s;
    for (int count = 1; count != 0 && now_s(board) < end;) {
        const double until = now_s(board) + (on_spi(board) ? spi_silence_s : silence_s);
        count = receive(board, bytes, sizeof bytes, true, until);
        if (count < 0) return count;
    }
    return WH_OK;
}

static int settle_once(struct wh_board *board) {
    int result = drain(board);
    if (result) return result;
    board->probes = board->probes % WH_IDENTITY_COUNT + 1;
    const struct question asked = {.function = READ, .at = 0, .count = board->probes};
    uint8_t bytes[2 * ANSWER_MOST];
    result = send_bytes(board, bytes, frame_of(bytes, board->unit, &asked));
    if (result) return result;
    const size_t length = 5 + 4 * board->probes;
    const double until = now_s(board) + board->timeout_s;
    for (size_t count = 0;;) {
        // The newest bytes are kept: the answer is the last that comes.
        if (count > ANSWER_MOST) {
            memmove(bytes, bytes + (count - length), length);
            count = length;
        }
        const size_t room = on_spi(board) ? length : sizeof bytes - count;
        const int came = receive(board, bytes + count, room, count == 0, until);
        if (came < 0) return came;
        if (came == 0) return silent(board);
        count += (size_t)came;
        board->came += (size_t)came;
        for (size_t first = 0; first + length <= count; ++first) {
            const uint8_t *frame = bytes + first;
            uint8_t crc[4];
            put16(put16(crc, WH_WORDS_CRC >> 16), WH_WORDS_CRC & 0xffff);
            if (length_of(frame, length, board->unit, &asked) == length && sealed(frame, length) &&
                (!board->known || memcmp(frame + 3, crc, sizeof crc) == 0)) {
                board->astray = false;
                board->heard_s = now_s(board);
                return WH_OK;
            }
        }
    }
}

static int speak(struct wh_board *board, unsigned rate);
static int set_rate(struct wh_board *board, unsigned rate);

static void wait_s(const struct wh_board *board, double seconds) {
#ifndef WH_NO_SERIAL
    if (!on_spi(board)) {
        if (seconds > 0.0) (void)poll(NULL, 0, (int)(1e3 * seconds) + 1);
        return;
    }
#endif
    for (const double end = now_s(board) + seconds; now_s(board) < end;) continue;
}

// To the first rate, once a device that hasn't heard a good frame is there as well.
static int go_back(struct wh_board *board) {
    wait_s(board, fallback_s - (now_s(board) - board->heard_s));
    return speak(board, 0);
}

// Get into step with the device: nothing of earlier questions can come any more.
static int settle(struct wh_board *board) {
    int result = WH_SILENT;
    for (int n = 0; n < SETTLES && result == WH_SILENT; ++n) result = settle_once(board);
    if (result != WH_SILENT || board->rate == 0) return result;
    const unsigned rate = board->rate;
    result = go_back(board);
    if (!result) result = settle_once(board);
    return result ? result : set_rate(board, rate);
}

// Ask questions in one piece, and take their answers: 0, NONE_LEFT where one is missing or doesn't fit, or
// what is wrong. A refusal is told once all are answered.
static int ask_once(struct wh_board *board, struct question *asked, size_t questions) {
    uint8_t bytes[QUESTIONS_MOST > ANSWER_MOST ? QUESTIONS_MOST : ANSWER_MOST];
    size_t count = 0;
    for (size_t n = 0; n < questions; ++n) count += frame_of(bytes + count, board->unit, asked + n);
    board->astray = true;  // until all is answered
    int result = send_bytes(board, bytes, count);
    if (result) return result;
    unsigned code = 0;
    const char *what = "";
    count = 0;
    for (size_t n = 0; n < questions; ++n) {
        const double until = now_s(board) + board->timeout_s;
        size_t length;
        while ((length = length_of(bytes, count, board->unit, asked + n)) > count) {
            // Of SPI no more is clocked than has to come.
            const size_t room = on_spi(board) ? length - count : sizeof bytes - count;
            const int came = receive(board, bytes + count, room, count == 0, until);
            if (came < 0) return came;
            if (came == 0) return NONE_LEFT;
            count += (size_t)came;
            board->came += (size_t)came;
        }
        if (length == 0 || !sealed(bytes, length)) return NONE_LEFT;
        board->heard_s = now_s(board);
        if (bytes[1] & REFUSES) {
            if (!code) {
                code = bytes[2];
                what = asked[n].what;
            }
        } else if (asked[n].function == READ) {
            for (unsigned k = 0; k < asked[n].count; ++k) {
                const uint8_t *word = bytes + 3 + 4 * k;
                asked[n].found[k] = (uint32_t)word[0] << 24 | (uint32_t)word[1] << 16 |
                                    (uint32_t)word[2] << 8 | word[3];
            }
        }
        memmove(bytes, bytes + length, count - length);
        count -= length;
    }
    if (count) return NONE_LEFT;  // more than was asked for
    board->astray = false;
    board->came = 0;
    if (code == 0) return WH_OK;
    const char *meaning = "unknown";
    switch (code) {
#define WH_CASE(number, text) \
    case number: meaning = text; break;
        WH_EXCEPTIONS(WH_CASE)
#undef WH_CASE
        default: break;
    }
    return fail(board, WH_REFUSED, "%s: the device refuses with exception %u: %s", what, code, meaning);
}

// The same, again where an answer is missing. Whatever this library asks may be asked twice.
static int ask(struct wh_board *board, struct question *asked, size_t questions) {
    if (board->file < 0) return fail(board, WH_PORT, "%s: is closed", board->path);
    board->came = 0;
    for (int n = 0; n < TRIES; ++n) {
        if (board->astray) {
            const int result = settle(board);
            if (result) return result;
        }
        const int result = ask_once(board, asked, questions);
        if (result != NONE_LEFT) return result;
    }
    return silent(board);
}

static int read_words(struct wh_board *board, unsigned address, unsigned count, uint32_t *found,
                      const char *what) {
    struct question asked = {
        .function = READ, .at = word_register(address), .count = count, .found = found, .what = what};
    return ask(board, &asked, 1);
}

static struct question writes(unsigned address, uint32_t word, const char *what) {
    struct question asked = {
        .function = WRITE, .at = word_register(address), .count = 1, .what = what};
    asked.words[0] = word;
    return asked;
}

// ---- Opening.

#ifdef WH_NO_SERIAL

static int speak(struct wh_board *board, unsigned rate) {
    board->rate = rate;
    return WH_OK;
}

#else

static bool speed_of(unsigned baud, speed_t *speed) {
    switch (baud) {
        case 115200: *speed = B115200; return true;
#ifdef B1000000
        case 1000000: *speed = B1000000; return true;
#endif
#ifdef B1500000
        case 1500000: *speed = B1500000; return true;
#endif
#ifdef B3000000
        case 3000000: *speed = B3000000; return true;
#endif
        default: return false;
    }
}

static int speak(struct wh_board *board, unsigned rate) {
    struct termios line;
    speed_t speed;
    if (on_spi(board)) {
        board->rate = rate;
        return WH_OK;
    }
    if (tcgetattr(board->file, &line) != 0) return gone(board);
    line.c_iflag = 0;
    line.c_oflag = 0;
    line.c_lflag = 0;
    line.c_cflag = CS8 | CREAD | CLOCAL;
    line.c_cc[VMIN] = 1;  // no bytes are EAGAIN, and 0 is the end
    line.c_cc[VTIME] = 0;
    // Noted before, so that it is gone back from a rate that the port's driver refuses.
    board->rate = rate;
    if (!speed_of(rates[rate], &speed) || cfsetispeed(&line, speed) != 0 ||
        cfsetospeed(&line, speed) != 0 || tcsetattr(board->file, TCSADRAIN, &line) != 0) {
        return fail(board, WH_PORT, "%s: can't be set to %u bits a second", board->path, rates[rate]);
    }
    return WH_OK;
}

#endif

static int identify(struct wh_board *board) {
    struct question asked = {.function = READ, .at = 0, .count = WH_IDENTITY_COUNT,
                             .found = board->identity.words, .what = "the identification"};
    const int result = ask(board, &asked, 1);
    if (result) return result;
    const uint32_t *words = board->identity.words;
    if (words[ID_VERSION] != WH_MAP_VERSION) {
        return fail(board, WH_DEVICE,
                    "%s: the device's map of registers is of version %lu, not %u; take the library of "
                    "its bitstream",
                    board->path, (unsigned long)words[ID_VERSION], WH_MAP_VERSION);
    }
    if (words[ID_TABLE] != WH_WORDS_CRC) {
        return fail(board, WH_DEVICE,
                    "%s: the device has another table of words, CRC %08lx and not %08lx; take the "
                    "library of its bitstream",
                    board->path, (unsigned long)words[ID_TABLE], (unsigned long)WH_WORDS_CRC);
    }
#define WH_TAKE(name, low, bits) board->identity.name = words[ID_OPTIONS] >> (low) & ((1u << (bits)) - 1);
    WH_OPTIONS(WH_TAKE)
#undef WH_TAKE
    board->known = true;
    return WH_OK;
}

// The device, and then the port, at a rate; as it was where that doesn't work.
static int set_rate(struct wh_board *board, unsigned rate) {
    struct question asked = {.function = WRITE, .at = 2 * ID_RATE, .count = 1, .what = "rate"};
    asked.words[0] = rate;
    int result = ask(board, &asked, 1);
    if (result) return result;
    result = speak(board, rate);
    if (!result) result = settle_once(board);
    if (!result) return WH_OK;
    char why[WH_MESSAGE];
    memcpy(why, board->message, sizeof why);
    board->astray = true;
    if (go_back(board) == WH_OK) (void)settle_once(board);
    memcpy(board->message, why, sizeof why);  // the first error, whatever became of the way back
    return result;
}

#ifndef WH_NO_SERIAL

static int raise_rate(struct wh_board *board, unsigned baud) {
    const uint32_t has = board->identity.words[ID_RATES];
    unsigned most = has < RATES ? (unsigned)has : RATES;
    if (baud == 0) {
        const int result = most > 1 ? set_rate(board, most - 1) : WH_OK;
        return board->astray ? result : WH_OK;
    }
    unsigned rate = 0;
    while (rate < RATES && rates[rate] != baud) ++rate;
    if (rate == RATES) {
        return fail(board, WH_VALUE,
                    "%s: a device has no %u bits a second; take %u, %u, %u or %u", board->path, baud,
                    rates[0], rates[1], rates[2], rates[3]);
    }
    if (rate >= most && rate > 0) {
        return fail(board, WH_DEVICE, "%s: the device's clock is too slow for %u bits a second; take %u",
                    board->path, baud, rates[most ? most - 1 : 0]);
    }
    return rate ? set_rate(board, rate) : WH_OK;
}

#endif

static int open_board(struct wh_board *board, const char *path, const struct wh_options *options) {
    const struct wh_options usual = {0};
    if (!options) options = &usual;
    memset(board, 0, sizeof *board);
    board->file = -1;
    board->unit = options->unit ? options->unit : 1;
    board->timeout_s = options->timeout_s > 0.0 ? options->timeout_s : 0.1;
    (void)snprintf(board->path, sizeof board->path, "%s", path);
    if (board->unit > 247) {
        return fail(board, WH_VALUE, "unit %u: there are units 1...247", board->unit);
    }
    struct question off = writes(rows[WH_WORD_ARM].address, 0, "arm");
    (void)frame_of(board->stop, board->unit, &off);
    return WH_OK;
}

// Into step with a device whose line is open.
static int meet(struct wh_board *board) {
    board->heard_s = now_s(board);
    board->astray = true;  // a host before may have left questions
    int result = settle(board);
    if (result == WH_SILENT) {
        // One that was left at another rate goes back by itself.
        (void)go_back(board);
        result = settle(board);
    }
    return result ? result : identify(board);
}

int wh_open_spi(struct wh_board *board, const struct wh_spi *spi, const struct wh_options *options) {
    int result = open_board(board, "SPI", options);
    if (result) return result;
    if (!spi->transfer || !spi->now_s) {
        return fail(board, WH_VALUE, "SPI: needs both a transfer and a clock, now_s");
    }
    board->spi = *spi;
    board->file = 0;
    result = meet(board);
    if (result) wh_close(board);
    return result;
}

#ifndef WH_NO_SERIAL

static int open_line(struct wh_board *board, const char *path) {
    board->file = open(path, O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (board->file < 0) {
        return fail(board, WH_PORT, "%s: can't be opened: %s; is it plugged in? Else name the device's port",
                    board->path, strerror(errno));
    }
    if (!isatty(board->file)) {
        return fail(board, WH_PORT, "%s: is no serial line; name the device's port", board->path);
    }
    if (flock(board->file, LOCK_EX | LOCK_NB) != 0) {
        return fail(board, WH_PORT,
                    "%s: can't be opened: somebody else has it; end that program, or name another port",
                    board->path);
    }
    const int result = speak(board, 0);
    if (result) return result;
    (void)tcflush(board->file, TCIOFLUSH);
    return WH_OK;
}

int wh_open(struct wh_board *board, const char *path, const struct wh_options *options) {
    int result = open_board(board, path, options);
    if (!result) result = open_line(board, path);
    if (!result) result = meet(board);
    if (!result) result = raise_rate(board, options ? options->baud : 0);
    if (result) wh_close(board);
    return result;
}

#endif

void wh_close(struct wh_board *board) {
    if (board->file < 0) return;
#ifndef WH_NO_SERIAL
    if (!on_spi(board)) {
        if (board->rate != 0 && board->known) {
            // The next host begins at the first rate. Without an answer the device goes back by itself.
            struct question asked = {.function = WRITE, .at = 2 * ID_RATE, .count = 1, .what = "rate"};
            char why[WH_MESSAGE];
            memcpy(why, board->message, sizeof why);
            if (!board->astray) (void)ask_once(board, &asked, 1);
            memcpy(board->message, why, sizeof why);
        }
        (void)close(board->file);
    }
#endif
    board->file = -1;
}

// ---- Words.

static int place_of(struct wh_board *board, enum wh_word word, unsigned motor, unsigned index,
                    const struct row **found, unsigned *address) {
    if ((unsigned)word >= WH_WORD_COUNT) {
        return fail(board, WH_VALUE, "there is no word %u; take one of enum wh_word", (unsigned)word);
    }
    const struct row *row = *found = &rows[word];
    const struct wh_identity *device = &board->identity;
    // Brushless motors have no W, and two ports each. The first one has the words of both.
    const int brushless = device->shaper == WH_BRUSHLESS_SHAPER;
    const unsigned sections = brushless ? 0 : device->shaper;
    const unsigned motors = (brushless ? WH_AXES : 1) * device->words[ID_MOTORS];
    const unsigned each = row->of == WH_OF_WALL ? device->walls : row->of == WH_OF_SECTION ? sections : 1;
    const unsigned copies = each * row->count;
    if (row->of != WH_OF_BOARD && motor >= motors) {
        return fail(board, WH_VALUE, "%s: the device has no motor %u", row->name, motor);
    }
    if (index >= copies) {
        return fail(board, WH_VALUE, "%s: the device has %u, and no index %u", row->name, copies, index);
    }
    *address = row->address + index + (row->of == WH_OF_BOARD ? 0 : motor * WH_MOTOR_STRIDE);
    return WH_OK;
}

static double step_of(const struct row *row) { return 1.0 / (double)(UINT64_C(1) << row->fraction); }

static double value_of(enum wh_word word, uint32_t raw) {
    const struct row *row = &rows[word];
    int64_t number = raw;
    if (row->has_sign && raw >> 31) number -= INT64_C(1) << 32;
    return (double)number * step_of(row);
}

// The raw word of a value, which is in range once it is rounded.
static int raw_of(struct wh_board *board, enum wh_word word, double value, uint32_t *raw) {
    const struct row *row = &rows[word];
    const double high = row->high == WH_BY_DELAY ? (double)((1u << board->identity.delay_log2) - 1) : row->high;
    const double step = step_of(row), scaled = value / step;
    // Far out, or not a number.
    if (!(scaled > -9e15 && scaled < 9e15)) {
        return fail(board, WH_VALUE, "%s = %.9g is out of range; it takes %.9g...%.9g %s", row->name, value,
                    row->low, high, row->unit);
    }
    const int64_t rounded = (int64_t)(scaled < 0.0 ? scaled - 0.5 : scaled + 0.5);
    if (row->fraction == 0 && (double)rounded != value) {
        return fail(board, WH_VALUE, "%s = %.9g is no whole number; it takes %.9g...%.9g %s", row->name,
                    value, row->low, high, row->unit);
    }
    if ((double)rounded < row->low / step || (double)rounded > high / step) {
        return fail(board, WH_VALUE, "%s = %.9g is out of range; it takes %.9g...%.9g %s", row->name, value,
                    row->low, high, row->unit);
    }
    *raw = (uint32_t)(uint64_t)rounded;
    return WH_OK;
}

int wh_get(struct wh_board *board, enum wh_word word, unsigned motor, unsigned index, double *value) {
    const struct row *row;
    unsigned address;
    uint32_t raw;
    int result = place_of(board, word, motor, index, &row, &address);
    if (result) return result;
    if (row->kind == WH_COMMAND || row->kind == WH_MEMORY) {
        return fail(board, WH_VALUE, "%s can't be read; it is a command", row->name);
    }
    result = read_words(board, address, 1, &raw, row->name);
    if (!result) *value = value_of(word, raw);
    return result;
}

int wh_set(struct wh_board *board, enum wh_word word, unsigned motor, unsigned index, double value) {
    const struct row *row;
    unsigned address;
    uint32_t raw;
    int result = place_of(board, word, motor, index, &row, &address);
    if (result) return result;
    if (row->kind == WH_LIVE) {
        return fail(board, WH_VALUE, "%s can't be set; it is what the device tells", row->name);
    }
    if (row->kind == WH_MEMORY) {
        return fail(board, WH_VALUE, "%s can't be set; the link gives what it has written itself", row->name);
    }
    result = raw_of(board, word, value, &raw);
    if (result) return result;
    struct question asked = writes(address, raw, row->name);
    return ask(board, &asked, 1);
}

// ---- Arming.

static const char *refusals(uint32_t bits, char *text, size_t room) {
    text[0] = '\0';
#define WH_APPEND(bit, what) \
    if (bits >> (bit) & 1) append(text, room, text[0] ? ", " : "", what);
    WH_ARM_REFUSALS(WH_APPEND)
#undef WH_APPEND
    return text;
}

const char *wh_fault_text(uint32_t faults, char *text, size_t room) {
    if (room == 0) return "";
    text[0] = '\0';
#define WH_APPEND(bit, NAME, what) \
    if (faults >> (bit) & 1) append(text, room, text[0] ? ", " : "", (what)[0] ? (what) : #NAME);
    WH_FAULTS(WH_APPEND)
#undef WH_APPEND
    return text;
}

int wh_faults(struct wh_board *board, uint32_t *faults) {
    return read_words(board, rows[WH_WORD_FAULTS].address, 1, faults, "faults");
}

// Why the bridges are off, as far as the device says.
static int why_off(struct wh_board *board, uint32_t refused, const char *doing) {
    char reasons[128], found[96];
    uint32_t faults = 0;
    int result = wh_faults(board, &faults);
    if (result) return result;
    refusals(refused, reasons, sizeof reasons);
    if (faults) append(reasons, sizeof reasons, reasons[0] ? ": " : "", wh_fault_text(faults, found, sizeof found));
    return fail(board, WH_OFF, "%s: %s: %s", board->path, doing,
                reasons[0] ? reasons : "they were disarmed; arm them again");
}

enum { ARMED, ARM_REFUSED, ARM_WORDS };

static int read_arming(struct wh_board *board, uint32_t found[ARM_WORDS]) {
    return read_words(board, rows[WH_WORD_ARMED].address, ARM_WORDS, found, "armed");
}

int wh_arm(struct wh_board *board) {
    struct question asked = writes(rows[WH_WORD_ARM].address, 1, "arm");
    uint32_t found[ARM_WORDS];
    int result = ask(board, &asked, 1);
    const double most = board->timeout_s > arming_s ? board->timeout_s : arming_s;
    for (const double until = now_s(board) + most; !result;) {
        result = read_arming(board, found);
        if (result) break;
        if (found[ARMED]) {
            board->renewed_s = now_s(board);
            return WH_OK;
        }
        if (found[ARM_REFUSED] || now_s(board) > until) return why_off(board, found[ARM_REFUSED], "can't be armed");
    }
    return result;
}

static void renewal(struct question asked[2]) {
    asked[0] = writes(rows[WH_WORD_HOST_ALIVE].address, 1, "host_alive");
    asked[1] = writes(rows[WH_WORD_ARM].address, 2, "arm");
}

int wh_renew(struct wh_board *board) {
    struct question asked[2];
    renewal(asked);
    const int result = ask(board, asked, 2);
    if (!result) board->renewed_s = now_s(board);
    return result;
}

int wh_disarm(struct wh_board *board) {
    struct question asked = writes(rows[WH_WORD_ARM].address, 0, "arm");
    uint32_t found[ARM_WORDS];
    int result = ask(board, &asked, 1);
    if (!result) result = read_arming(board, found);
    if (!result && found[ARMED]) {
        result = fail(board, WH_REFUSED,
                      "%s: the bridges are still on; this device has a switch for them (ARM = 0)",
                      board->path);
    }
    return result;
}

void wh_stop(const struct wh_board *board) {
    if (board->file < 0) return;
    if (on_spi(board)) {
        uint8_t in[sizeof board->stop];
        (void)board->spi.transfer(board->spi.context, board->stop, in, sizeof in);
        return;
    }
#ifndef WH_NO_SERIAL
    const int kept = errno;
    // What it may run into is the library's own frame: after a silence the second one is whole.
    for (int n = 0; n < 2; ++n) {
        if (write(board->file, board->stop, sizeof board->stop) < 0 && errno != EAGAIN) break;
        (void)poll(NULL, 0, 10);
    }
    errno = kept;
#endif
}

// ---- A motor's port.

int wh_port_open(struct wh_port *port, struct wh_board *board, unsigned motor,
                 const struct wh_motor *data) {
    const double pi = 3.14159265358979323846;
    double halves = 0.0, clocks = 0.0, log2 = 0.0, timeout = 0.0, root = 0.0;
    memset(port, 0, sizeof *port);
    port->board = board;
    port->motor = motor;
    port->sequence = -1;
    if (!(data->k_t > 0.0 && data->counts_per_rev >= 1.0)) {
        return fail(board, WH_VALUE, "a motor needs k_t above 0 N·m/A and counts_per_rev of 1 or more");
    }
    int result = wh_get(board, WH_WORD_ROOT, motor, 0, &root);
    if (!result) result = wh_get(board, WH_WORD_HALF_CLOCKS, 0, 0, &clocks);
    if (!result) result = wh_get(board, WH_WORD_TICK_HALVES, 0, 0, &halves);
    if (!result) result = wh_get(board, WH_WORD_HOST_PERIOD_LOG2, 0, 0, &log2);
    if (!result) result = wh_get(board, WH_WORD_HOST_TIMEOUT, 0, 0, &timeout);
    if (result) return result;
    if (!(root > 0.0)) {
        return fail(board, WH_DEVICE, "root of motor %u is 0: set it to the square root of 2 R first", motor);
    }
    port->k_t = data->k_t;
    port->count_rad = 2.0 * pi / data->counts_per_rev;
    port->s = root;
    port->b = 2.0 * data->k_t * data->k_t / (root * root);
    port->tick_s = clocks * halves / (double)board->identity.words[ID_CLOCK_HZ];
    if (board->identity.host) port->period_s = port->tick_s * (double)(1u << (unsigned)log2);
    port->timeout = (unsigned)timeout;
    return WH_OK;
}

// ---- Surfaces.

enum { SURFACES, ACTING, PENDING, REFUSED_ROW, STAMP, SURFACES_WORDS };

int wh_read_surfaces(struct wh_board *board, struct wh_surfaces *state) {
    uint32_t found[SURFACES_WORDS];
    const int result = read_words(board, rows[WH_WORD_SURFACES].address, SURFACES_WORDS, found, "surfaces");
    if (result) return result;
    state->surfaces = (unsigned)found[SURFACES];
    state->acting = (unsigned)found[ACTING];
    state->pending = found[PENDING] != 0;
    state->refused = (unsigned)found[REFUSED_ROW];
    state->stamp = (unsigned)found[STAMP];
    return WH_OK;
}

int wh_set_planes(struct wh_board *board, const struct wh_surface_word *words, size_t count, unsigned stamp,
                  struct wh_surfaces *state) {
    enum { NOT_WHOLE = 255 };
    const size_t room = rows[WH_WORD_SURFACE_WORD].count;
    const unsigned commit = rows[WH_WORD_SURFACE_COMMIT].address;
    if (stamp > 0xffff) return fail(board, WH_VALUE, "stamp = %u: it has 16 bits; give 0...65535", stamp);
    uint32_t head = 1u << 31;  // the frame begins
    size_t n = 0;
    do {
        struct question asked = {.function = WRITE, .what = "planes"};
        size_t filled = 0;
        while (n < count && filled + 2 <= room) {
            size_t run = 1;
            while (n + run < count && filled + 1 + run < room && words[n + run].address == words[n].address + run) ++run;
            asked.words[filled++] = head | (uint32_t)run << 10 | (words[n].address & 0x3ffu);
            for (size_t k = 0; k < run; ++k) asked.words[filled++] = (uint32_t)words[n + k].word;
            n += run;
            head = 0;
        }
        if (!count) asked.words[filled++] = head;
        asked.at = word_register(commit - (unsigned)filled);
        if (n == count) asked.words[filled++] = stamp;
        asked.count = (unsigned)filled;
        const int result = ask(board, &asked, 1);
        if (result) return result;
    } while (n < count);
    if (!state) return WH_OK;
    const int result = wh_read_surfaces(board, state);
    if (result) return result;
    // The end of a frame that was accepted may have come once more, as its answer was lost.
    if (state->stamp == stamp && (state->refused == 0 || state->refused == NOT_WHOLE)) return WH_OK;
    return fail(board, WH_REFUSED, "planes: the device refuses row %u; what it had before is in force",
                state->refused & 127u);
}

// What follows is that of controller/planes.py, in its order.

// Square root by Newton's steps, so that no library of mathematics is needed.
static double root_of(double x) {
    double root = x > 1.0 ? x : 1.0;
    if (!(x > 0.0)) return 0.0;
    for (double next = 0.5 * (root + x / root); next < root; next = 0.5 * (root + x / root)) root = next;
    return root;
}

static int64_t fixed(double value, unsigned fraction, unsigned width) {
    const double most = (double)((int64_t)1 << (width - 1));
    const double raw = value * (double)((int64_t)1 << fraction);
    if (raw >= most - 1.0) return ((int64_t)1 << (width - 1)) - 1;
    if (raw <= -most) return -((int64_t)1 << (width - 1));
    return (int64_t)(raw < 0.0 ? raw - 0.5 : raw + 0.5);
}

enum {
    SURFACE_Q = 25, DISTANCE_Q = 8, CELLS_Q = 12, BEND_UP = 32, GAIN_UP = 32, MIX_Q = 22, MIX_UP = 8, WORD = 27,
    DISTANCE_WORD = 40, WAVE_Q = 23, WAVE_WORD = 31, PLANE_ROW = 96, VELOCITY_ROW = 112, VECTOR = 6,
    MOST = WH_SPACE_PLANES
};
static const double wall_time_s = 2e-3, least_lever = 0.05, least_angle = 0.1, budget_j = 1e-3;
static const double fastest_wave = 1e9;  // more than its word has

int wh_space_open(struct wh_space *space, struct wh_board *board, const struct wh_space_motor *motors,
                  unsigned count, double speed) {
    const double pi = 3.14159265358979323846;
    double clocks = 0.0, halves = 0.0, extra = 0.0;
    struct wh_surfaces state = {0};
    memset(space, 0, sizeof *space);
    space->board = board;
    if (count < 2 || count > WH_SPACE_MOTORS) return fail(board, WH_VALUE, "%u motors: planes lie across 2 or 3", count);
    if (!(speed >= 0.0)) return fail(board, WH_VALUE, "the largest speed of a surface has to be 0 or more, in m/s");
    int result = wh_read_surfaces(board, &state);
    if (result) return result;
    if (!state.surfaces) return fail(board, WH_DEVICE, "the device has no surfaces; take a bitstream with SURFACES");
    result = wh_get(board, WH_WORD_HALF_CLOCKS, 0, 0, &clocks);
    if (!result) result = wh_get(board, WH_WORD_TICK_HALVES, 0, 0, &halves);
    if (!result) result = wh_get(board, WH_WORD_EXTRA_TICKS, 0, 0, &extra);
    if (result) return result;
    space->motors = count;
    space->speed = speed;
    space->planes = state.surfaces < MOST ? state.surfaces : MOST;
    space->tick_s = clocks * halves / (double)board->identity.words[ID_CLOCK_HZ];
    space->delay_s = space->tick_s;
    for (unsigned n = 0; n < count; ++n) {
        const double k_t = motors[n].k_t;
        double root = 0.0, a = 0.0;
        if (!(k_t > 0.0 && motors[n].inductance >= 0.0 && motors[n].counts_per_rev >= 1.0)) {
            return fail(board, WH_VALUE,
                        "motor %u needs k_t above 0, inductance of 0 or more, counts_per_rev of 1 or more", n);
        }
        result = wh_get(board, WH_WORD_ROOT, n, 0, &root);
        if (!result) result = wh_get(board, WH_WORD_A, n, 0, &a);
        if (result) return result;
        if (!(root > 0.0 && a > 0.0)) {
            return fail(board, WH_DEVICE, "root or a of motor %u is 0; set the motor's registers first", n);
        }
        const double r_hat = 0.5 * root * root, tau = space->tick_s / a + extra * space->tick_s;
        space->k_t[n] = k_t;
        if (tau > space->delay_s) space->delay_s = tau;
        space->count_rad[n] = 2.0 * pi / motors[n].counts_per_rev;
        space->damping[n] = r_hat / (k_t * k_t);
        space->compliance[n] = (motors[n].inductance + 0.5 * r_hat * tau) / (k_t * k_t);
    }
    result = wh_set(board, WH_WORD_SURFACE_BUDGET, 0, 0, budget_j / space->tick_s);
    return result ? result : wh_space_read(space);
}

// A value of each motor, asked for in one piece.
static int of_motors(const struct wh_space *space, enum wh_word word, double *values) {
    struct question asked[WH_SPACE_MOTORS];
    uint32_t raw[WH_SPACE_MOTORS];
    for (unsigned n = 0; n < space->motors; ++n) {
        asked[n] = (struct question){
            .function = READ, .at = word_register(rows[word].address + n * WH_MOTOR_STRIDE), .count = 1,
            .found = &raw[n], .what = rows[word].name};
    }
    const int result = ask(space->board, asked, space->motors);
    for (unsigned n = 0; !result && n < space->motors; ++n) values[n] = value_of(word, raw[n]);
    return result;
}

int wh_space_read(struct wh_space *space) {
    const int result = of_motors(space, WH_WORD_POSITION, space->counts);
    for (unsigned n = 0; !result && n < space->motors; ++n) {
        space->angles[n] = (space->counts[n] + 0.5) * space->count_rad[n];
    }
    return result;
}

struct frame {
    struct wh_surface_word words[700];
    size_t count;
};

static void put_word(struct frame *frame, unsigned row, unsigned at, int64_t word) {
    frame->words[frame->count].address = (uint16_t)(8 * row + at);
    frame->words[frame->count++].word = (int32_t)word;
}

static void put_vector(struct frame *frame, unsigned row, const double vector[VECTOR]) {
    const double longest = (1.0 - 1.0 / 16777216.0) * 33554432.0;  // below 1, rounded to 0: none is longer than 1
    for (unsigned n = 0; n < 3; ++n) put_word(frame, row, n, (int64_t)(vector[n] * longest));
    for (unsigned n = 3; n < VECTOR; ++n) put_word(frame, row, n, fixed(vector[n], MIX_Q, WORD) * MIX_UP);
}

// That of the last of a set: one that rests deep in its own spring doesn't move a surface that has none.
static void put_set(struct frame *frame, unsigned row, const double vector[VECTOR], const struct wh_plane *const set[],
                    unsigned before) {
    double parted[VECTOR];
    memcpy(parted, vector, sizeof parted);
    for (unsigned n = 0; n < before; ++n) {
        if (set[n]->damping > 0.0 && set[before]->damping == 0.0) parted[3 + n] = 0.0;
    }
    put_vector(frame, row, parted);
}

// The vector of a surface, orthogonal to those of `before`, or zeros where there is no further direction.
static void beside(double before[][VECTOR], unsigned count, const double row[VECTOR], double found[VECTOR]) {
    double square = 0.0;
    for (unsigned n = 0; n < VECTOR; ++n) found[n] = n < 3 ? row[n] : n == 3 + count ? 1.0 : 0.0;
    for (unsigned k = 0; k < count; ++k) {
        const double common = row[0] * before[k][0] + row[1] * before[k][1] + row[2] * before[k][2];
        for (unsigned n = 0; n < VECTOR; ++n) found[n] -= common * before[k][n];
    }
    for (unsigned n = 0; n < 3; ++n) square += found[n] * found[n];
    const double length = root_of(square);
    for (unsigned n = 0; n < VECTOR; ++n) found[n] = length >= least_angle ? found[n] / length : 0.0;
}

int wh_space_planes(struct wh_space *space, double jacobian[3][WH_SPACE_MOTORS], const struct wh_plane *planes,
                    size_t count, unsigned stamp, struct wh_surfaces *state) {
    static const unsigned pairs[MOST] = {0, 0, 1, 3, 6, 10, 15, 21}, triples[MOST] = {0, 0, 0, 1, 4, 10, 20, 35};
    struct wh_board *const board = space->board;
    double vectors[MOST][VECTOR] = {{0.0}}, velocity = 0.0, lever = 0.0;
    struct frame frame = {.count = 0};
    bool damped = false;
    if (count > space->planes) {
        return fail(board, WH_VALUE, "%u planes, and the device has %u; give the nearest", (unsigned)count,
                    space->planes);
    }
    for (unsigned row = 0; row < 3; ++row) {
        for (unsigned n = 0; n < space->motors; ++n) lever += jacobian[row][n] * jacobian[row][n];
    }
    put_word(&frame, VELOCITY_ROW, 0, 0);
    for (unsigned k = 0; k < (unsigned)count; ++k) {
        const struct wh_plane *const plane = &planes[k];
        const double *const out = plane->normal;
        const double length = root_of(out[0] * out[0] + out[1] * out[1] + out[2] * out[2]);
        double along[3] = {0.0}, scale = 0.0, drag = 0.0, soft = 0.0, reach = 0.0, place = 0.0, tau = 0.0;
        double eta = -1.0, wall_s = wall_time_s;
        if (!(length > 0.0 && plane->stiffness >= 0.0 && plane->loss >= 0.0 && plane->loss <= 1.0) ||
            plane->distance != plane->distance) {
            return fail(board, WH_VALUE,
                        "plane %u needs a normal, a distance, a stiffness of 0 or more, a loss of 0...1", k);
        }
        if (!(plane->damping == 0.0 || (plane->damping > 0.0 && plane->stiffness > 0.0))) {
            return fail(board, WH_VALUE, "plane %u: damping has to be 0, or above that with a stiffness", k);
        }
        for (unsigned n = 0; n < space->motors; ++n) {
            for (unsigned row = 0; row < 3; ++row) along[n] -= jacobian[row][n] * out[row] / length;
            scale += along[n] * along[n] * space->count_rad[n] * space->count_rad[n];
            drag += along[n] * along[n] * space->damping[n];
            soft += along[n] * along[n] * space->compliance[n];
            reach += along[n] * along[n];
        }
        if (!(reach >= least_lever * least_lever * lever && reach > 0.0)) {
            return fail(board, WH_VALUE,
                        "plane %u: no motor moves the tip along its normal; leave it out or move the arm", k);
        }
        scale = root_of(scale);
        const double root = root_of(2.0 * drag), fastest = 2.0 * space->speed / root, wave = root_of(drag);
        const double softer = plane->stiffness * soft < 1.0 ? 1.0 / plane->stiffness - soft : 0.0;
        if (plane->stiffness > 0.0 && plane->damping == 0.0) {
            tau = 2.0 * softer / drag;
        } else if (plane->damping > 0.0 && plane->damping * softer >= space->delay_s) {
            const double part = plane->damping * drag;
            eta = (1.0 - part) / (1.0 + part);
            wall_s = (1.0 + part) * softer / drag;
        }
        velocity = k == 0 || fastest < velocity ? fastest : velocity;
        damped = damped || plane->damping > 0.0;
        for (unsigned n = 0; n < space->motors; ++n) {
            place += along[n] * space->count_rad[n] / scale * space->counts[n];
            vectors[k][n] = along[n] * root_of(space->damping[n]) / wave;
        }
        vectors[k][3] = 1.0;
        const unsigned row = PLANE_ROW + 2 * k;
        const int64_t d = fixed(place + plane->distance / scale, DISTANCE_Q, DISTANCE_WORD);
        const int64_t whole = (d - (d & 255)) / 256;
        put_word(&frame, row, 0, whole);
        put_word(&frame, row, 1, 256 | (d & 255));
        for (unsigned n = 0; n < 3; ++n) {
            put_word(&frame, row, 2 + n, fixed(along[n] * space->count_rad[n] / scale, SURFACE_Q, WORD));
        }
        for (unsigned n = 0; n < 3; ++n) {
            const double bend = space->compliance[n] + 0.5 * tau * space->damping[n];
            put_word(&frame, row, 5 + n, fixed(along[n] * bend * space->k_t[n] / scale, CELLS_Q, WORD) * BEND_UP);
        }
        put_word(&frame, row + 1, 0, fixed(2.0 * scale / (wall_s * root), SURFACE_Q, WORD) * GAIN_UP);
        put_word(&frame, row + 1, 1, fixed(space->tick_s / (space->tick_s + tau), SURFACE_Q, WORD));
        put_word(&frame, row + 1, 2, fixed(eta, SURFACE_Q, WORD));
        put_word(&frame, row + 1, 3, fixed(1.0 - plane->loss, SURFACE_Q, WORD));
        put_vector(&frame, k, vectors[k]);
    }
    // A surface with damping moves as fast as its spring has to.
    frame.words[0].word = (int32_t)fixed(damped ? fastest_wave : velocity, WAVE_Q, WAVE_WORD);
    double set[3][VECTOR];
    for (unsigned i = 0; i < count; ++i) {
        for (unsigned j = i + 1; j < count; ++j) {
            beside(&vectors[i], 1, vectors[j], set[1]);
            put_set(&frame, MOST + pairs[j] + i, set[1], (const struct wh_plane *[]){&planes[i], &planes[j]}, 1);
        }
    }
    for (unsigned i = 0; i < count; ++i) {
        for (unsigned j = i + 1; j < count; ++j) {
            memcpy(set[0], vectors[i], sizeof set[0]);
            beside(&vectors[i], 1, vectors[j], set[1]);
            for (unsigned k = j + 1; k < count; ++k) {
                beside(set, 2, vectors[k], set[2]);
                put_set(&frame, MOST + 28 + triples[k] + pairs[j] + i, set[2],
                        (const struct wh_plane *[]){&planes[i], &planes[j], &planes[k]}, 2);
            }
        }
    }
    return wh_set_planes(board, frame.words, frame.count, stamp, state);
}

int wh_space_force(struct wh_space *space, double jacobian[3][WH_SPACE_MOTORS], double force[3]) {
    double m[3][3] = {{0.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}, torque[3] = {0.0}, by[3];
    const int result = of_motors(space, WH_WORD_CURRENT, torque);
    if (result) return result;
    for (unsigned n = 0; n < space->motors; ++n) {
        torque[n] *= space->k_t[n];
        for (unsigned k = 0; k < space->motors; ++k) {
            m[n][k] = 0.0;
            for (unsigned row = 0; row < 3; ++row) m[n][k] += jacobian[row][n] * jacobian[row][k];
        }
    }
    const double whole = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
                         m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
    force[0] = force[1] = force[2] = 0.0;
    if (!(whole > 1e-12 * m[0][0] * m[1][1] * m[2][2])) return WH_OK;
    for (unsigned n = 0; n < 3; ++n) {  // the cofactors of a symmetric matrix
        const unsigned a = (n + 1) % 3, b = (n + 2) % 3;
        by[n] = 0.0;
        for (unsigned k = 0; k < 3; ++k) {
            const unsigned c = (k + 1) % 3, d = (k + 2) % 3;
            by[n] += (m[a][c] * m[b][d] - m[a][d] * m[b][c]) * torque[k] / whole;
        }
    }
    for (unsigned row = 0; row < 3; ++row) {
        for (unsigned n = 0; n < space->motors; ++n) force[row] += jacobian[row][n] * by[n];
    }
    return WH_OK;
}

double wh_speed(const struct wh_port *port, double v, double torque) {
    return port->s * v / port->k_t + torque / port->b;
}

double wh_wave(const struct wh_port *port, double v, double torque) {
    return v + port->s * torque / port->k_t;
}

int wh_read_state(struct wh_port *port, struct wh_state *state) {
    enum { FOLLOWER_TICKS = 256 };
    // Of the step, and of the anchor: two frames, as there are no words between.
    const unsigned step = rows[WH_WORD_VOLTAGE].address, seen = rows[WH_WORD_CORRECTION].address;
    uint32_t raw[32];
    struct wh_board *board = port->board;
    const unsigned motor = port->motor * WH_MOTOR_STRIDE;
    const bool brushless = board->identity.shaper == WH_BRUSHLESS_SHAPER;
    const int last = brushless ? WH_WORD_SATURATED : WH_WORD_CONTACT_ENERGY;
    struct question asked[2] = {
        {.function = READ, .at = word_register(step + motor), .what = "the state", .found = raw,
         .count = rows[last].address - step + 1u},
        {.function = READ, .at = word_register(seen + motor), .what = "the anchor's state",
         .found = raw + (seen - step), .count = rows[WH_WORD_ANCHOR_FAULT].address - seen + 1u}};
    const int result = ask(board, asked, board->identity.anchor ? 2 : 1);
    if (result) return result;
#define WH_HERE(NAME) value_of(WH_WORD_##NAME, raw[rows[WH_WORD_##NAME].address - step])
    const double cells = WH_HERE(POSITION) + 0.5;
    state->count = (int32_t)WH_HERE(POSITION);
    state->current = WH_HERE(CURRENT);
    state->torque = port->k_t * state->current;
    state->contact = WH_HERE(CONTACT) != 0.0;
    state->saturated = WH_HERE(SATURATED) != 0.0;
    state->contact_energy = brushless ? 0.0 : WH_HERE(CONTACT_ENERGY) * port->k_t * port->count_rad;
    if (board->identity.anchor) {
        state->x = (cells - WH_HERE(FLUX)) * port->count_rad;
        state->omega = WH_HERE(LAG) * port->count_rad / (FOLLOWER_TICKS * port->tick_s);
        state->anchor_fault = WH_HERE(ANCHOR_FAULT) != 0.0;
    } else {
        state->x = cells * port->count_rad;
        state->omega = port->s * (WH_HERE(U) + WH_HERE(V)) / (2.0 * port->k_t);
        state->anchor_fault = false;
    }
#undef WH_HERE
    return WH_OK;
}

enum { SEQUENCE, V, ACTIVE, PACKET_WORDS };

// Read packets until there is a newer one. What `asked` has goes before the first read, in the same piece.
static int newer(struct wh_port *port, struct question *asked, size_t before, struct wh_packet *packet) {
    struct wh_board *board = port->board;
    uint32_t found[PACKET_WORDS];
    asked[before] = (struct question){
        .function = READ,
        .at = word_register(rows[WH_WORD_HOST_PACKET_SEQUENCE].address + port->motor * WH_MOTOR_STRIDE),
        .count = PACKET_WORDS, .found = found, .what = "host_packet_sequence"};
    int result = ask(board, asked, before + 1);
    for (const double until = now_s(board) + board->timeout_s + 4.0 * port->period_s;;) {
        if (result) return result;
        const int sequence = (int)(found[SEQUENCE] & 0xff);
        const bool begins = port->sequence < 0;
        if (!begins && sequence != port->sequence) {
            packet->sequence = (uint8_t)sequence;
            packet->periods = (unsigned)(sequence - port->sequence) & 0xff;
            packet->v = value_of(WH_WORD_HOST_V, found[V]);
            packet->active = found[ACTIVE] != 0;
            port->sequence = sequence;
            ++port->packets;
            port->missed += packet->periods - 1;
            return WH_OK;
        }
        if (begins) port->sequence = sequence;
        if (now_s(board) > until) break;
        result = ask(board, &asked[before], 1);
    }
    uint32_t arming[ARM_WORDS];
    result = read_arming(board, arming);
    if (result) return result;
    if (!arming[ARMED]) return why_off(board, arming[ARM_REFUSED], "no packets, the bridges are off");
    return fail(board, WH_SILENT, "%s: no new packet within %g s; a period is %g s", board->path,
                board->timeout_s, port->period_s);
}

static int needs_host(struct wh_port *port) {
    if (port->board->identity.host) return WH_OK;
    return fail(port->board, WH_DEVICE,
                "%s: the device has no link to a host; take a bitstream with HOST = 1, or a virtual board of "
                "a scene with [host]",
                port->board->path);
}

int wh_next(struct wh_port *port, struct wh_packet *packet) {
    struct question asked[1];
    const int result = needs_host(port);
    return result ? result : newer(port, asked, 0, packet);
}

int wh_exchange(struct wh_port *port, double u, struct wh_packet *packet) {
    struct wh_board *board = port->board;
    struct question asked[4];
    size_t count = 0;
    int result = needs_host(port);
    if (result) return result;
    if (port->sequence < 0) return fail(board, WH_VALUE, "there is no packet to be answered; take wh_next first");
    if (now_s(board) - board->renewed_s > renewal_s) {
        renewal(asked);
        count = 2;
    }
    asked[count] = (struct question){
        .function = WRITE,
        .at = word_register(rows[WH_WORD_HOST_ANSWER_SEQUENCE].address + port->motor * WH_MOTOR_STRIDE),
        .count = 3, .what = "host_u"};
    asked[count].words[0] = (uint32_t)port->sequence;
    result = raw_of(board, WH_WORD_HOST_U, u, &asked[count].words[1]);
    if (result) return result;
    asked[count].words[2] = 1;
    result = newer(port, asked, count + 1, packet);
    if (!result && count) board->renewed_s = now_s(board);
    return result;
}
