// Times of calls: histograms of the wall clock and of the thread's own time, and work of a known length to compare them with.
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

static inline double seconds_of(clockid_t clock) {
    struct timespec now;
    clock_gettime(clock, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static inline double seconds(void) { return seconds_of(CLOCK_MONOTONIC); }

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

static inline void print_header(void) { printf("| µs | count | p50 | p99 | p99.99 | most |\n|---|---|---|---|---|---|\n"); }

static inline void print_times(const char *name, const Histogram *times) {
    printf("| %s | %llu | %.1f | %.1f | %.1f | %.1f |\n", name, times->count, 1e6 * quantile(times, 0.5),
           1e6 * quantile(times, 0.99), 1e6 * quantile(times, 0.9999), 1e6 * times->most);
}

// Arithmetic in registers, each step after the last: it always takes the same time, unless the machine does something else.
static volatile unsigned long long worked;

static inline void work(unsigned long long steps) {
    unsigned long long number = steps;
    while (steps-- > 0) number = number * 6364136223846793005ull + 1442695040888963407ull;
    worked = number;
}

// How many steps take this long.
static inline unsigned long long steps_for(double time) {
    double least = 1;
    for (int i = 0; i < 20; ++i) {
        const double begin = seconds();
        work(100000);
        least = fmin(least, seconds() - begin);
    }
    return (unsigned long long)(time / least * 100000) + 1;
}

// Times by the wall clock, which go on while the system runs other programs, and by the thread's own time, in which only the
// system's interrupts are counted too.
typedef struct Times {
    Histogram wall, own;
    double wall_begin, own_begin;
} Times;

static inline void begin_time(Times *times) {
    times->own_begin = seconds_of(CLOCK_THREAD_CPUTIME_ID);
    times->wall_begin = seconds();
}

static inline void end_time(Times *times) {
    const double wall = seconds(), own = seconds_of(CLOCK_THREAD_CPUTIME_ID);
    add_time(&times->wall, wall - times->wall_begin);
    add_time(&times->own, own - times->own_begin);
}

// One kind of call, and the arithmetic that takes as long as its median.
typedef struct Call {
    const char *name;
    Times times, work;
    unsigned long long steps;
} Call;

// Forgets the times so far, which were for warming up. Their median says how much arithmetic is compared with the call.
static inline void start_measuring(Call *call) {
    call->steps = steps_for(quantile(&call->times.wall, 0.5));
    memset(&call->times, 0, sizeof call->times);
    memset(&call->work, 0, sizeof call->work);
}

// Ends the time of a call, and times the arithmetic.
static inline void end_call(Call *call) {
    end_time(&call->times);
    begin_time(&call->work);
    work(call->steps);
    end_time(&call->work);
}

static inline void print_call(const Call *call) {
    const Histogram *rows[] = {&call->times.wall, &call->work.wall, &call->times.own, &call->work.own};
    const char *suffixes[] = {"", ", arithmetic", ", own time", ", arithmetic, own time"};
    char name[100];
    for (int i = 0; i < 4; ++i) {
        snprintf(name, sizeof name, "%s%s", call->name, suffixes[i]);
        print_times(name, rows[i]);
    }
}

#endif
