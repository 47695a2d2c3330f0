// Times of calls: histograms of the thread's own time, in which only the system's interrupts are counted too, and work of a known length
// to compare them with.
#ifndef TIMES_H
#define TIMES_H

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

// A histogram whose buckets grow by 2 %.
enum { BUCKETS = 1024 };

typedef struct Histogram {
    unsigned long long count, buckets[BUCKETS];
    double most;
} Histogram;

static inline double own_seconds(void) {
    struct timespec now;
#ifdef _WIN32
    clock_gettime(CLOCK_MONOTONIC, &now); // the thread's own time has steps of 16 ms there
#else
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
#endif
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static inline void add_time(Histogram *times, double time) {
    const double at = log(fmax(time, 0) * 1e8 + 1) / log(1.02);
    ++times->buckets[at < BUCKETS - 1 ? (int)at : BUCKETS - 1];
    ++times->count;
    if (time > times->most) times->most = time;
}

static inline double quantile(const Histogram *times, double part) {
    unsigned long long below = 0;
    for (int i = 0; i < BUCKETS; ++i) {
        below += times->buckets[i];
        if ((double)below >= part * (double)times->count) return fmin((pow(1.02, i + 1) - 1) * 1e-8, times->most);
    }
    return times->most;
}

// Arithmetic in registers, each step after the last: it always takes the same time, unless the machine does something else.
static volatile unsigned long long worked;

static inline double time_of_work(unsigned long long steps) {
    const double begin = own_seconds();
    unsigned long long number = steps;
    while (steps-- > 0) number = number * 6364136223846793005ull + 1442695040888963407ull;
    worked = number;
    return own_seconds() - begin;
}

// One kind of call, and the arithmetic that takes as long as its median.
typedef struct Call {
    const char *name;
    double begin;
    Histogram times, work;
    unsigned long long steps;
} Call;

// Forgets the times so far, which were for warming up. Their median says how much arithmetic is compared with the call.
static inline void start_measuring(Call *call) {
    double least = 1;
    for (int i = 0; i < 20; ++i) least = fmin(least, time_of_work(100000));
    call->steps = (unsigned long long)(quantile(&call->times, 0.5) / fmax(least, 1e-6) * 100000) + 1;
    memset(&call->times, 0, sizeof call->times);
    memset(&call->work, 0, sizeof call->work);
}

static inline void begin_call(Call *call) { call->begin = own_seconds(); }

// Ends the time of a call, and times the arithmetic.
static inline void end_call(Call *call) {
    add_time(&call->times, own_seconds() - call->begin);
    add_time(&call->work, time_of_work(call->steps));
}

static inline void print_calls(const Call *const *calls, int count) {
    printf("| µs, own time | count | p50 | p99 | p99.99 | most |\n|---|---|---|---|---|---|\n");
    for (int i = 0; i < 2 * count; ++i) {
        const Histogram *times = i % 2 ? &calls[i / 2]->work : &calls[i / 2]->times;
        printf("| %s%s | %llu | %.1f | %.1f | %.1f | %.1f |\n", calls[i / 2]->name, i % 2 ? ", arithmetic as long" : "", times->count,
               1e6 * quantile(times, 0.5), 1e6 * quantile(times, 0.99), 1e6 * quantile(times, 0.9999), 1e6 * times->most);
    }
}

#endif
