// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Marks a function whose loops are compiled once for wide registers and once for every machine; the program's loader
// picks one, always the same on one machine. Not under the sanitizers, which are not awake yet when it picks.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define RAYBUNDLE_TARGET_CLONES __attribute__((target_clones("arch=x86-64-v3", "default")))
#else
#define RAYBUNDLE_TARGET_CLONES
#endif
