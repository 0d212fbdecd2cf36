// SPDX-License-Identifier: Apache-2.0
//
// What a model came through, if it was built to count that: a file of its own in $WH_COVERAGE.

#pragma once

#include "verilated.h"

#if VM_COVERAGE

#include <stdlib.h>
#include <unistd.h>

#include <string>

#include "verilated_cov.h"

inline void write_coverage(VerilatedContext &context) {
    const char *folder = getenv("WH_COVERAGE");
    if (!folder) return;
    std::string path = std::string(folder) + "/model-XXXXXX.dat";
    const int file = mkstemps(&path[0], 4);
    if (file < 0) return;
    close(file);
    context.coveragep()->write(path);
}

#else

inline void write_coverage(VerilatedContext &) {}

#endif
