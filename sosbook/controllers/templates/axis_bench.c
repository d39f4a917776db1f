/* axis_bench.c: the controller against its plants, at all corners
 *
 * (Where this comes from.)
 *
 * Linear plants, solved exactly from tick to tick, with the delay and the
 * steps of the sensors. Prints a row for each corner and returns 0 if no
 * fault came and all came to rest. It proves nothing.
 */
#include <stdio.h>
#include "axis.h"
#include "axis_plants.h"

static const axis_real F[BENCH_CORNERS][BENCH_STATES][BENCH_STATES] = BENCH_F;
static const axis_real G[BENCH_CORNERS][BENCH_STATES][AXIS_OUTPUTS] = BENCH_G;
static const axis_real H[AXIS_MEASURED][BENCH_STATES] = BENCH_H;
static const axis_real STEPS[AXIS_MEASURED] = BENCH_STEPS;

static axis_real size(axis_real value)
{
    return value < 0 ? -value : value;
}

/* The nearest whole number of steps, as an encoder has it. */
static axis_real counted(axis_real value, axis_real step)
{
    if (step <= 0)
        return value;
    const axis_real half = value < 0 ? (axis_real)-0.5 : (axis_real)0.5;
    return step * (axis_real)(long)(value / step + half);
}

static int run(int corner, const axis_real r[])
{
    axis_state s;
    axis_real x[BENCH_STATES] = {0}, y[AXIS_MEASURED], u[AXIS_OUTPUTS];
    axis_real largest = 0, moved = 0, over = 0, last[AXIS_MEASURED] = {0};
    for (long tick = 0; tick < BENCH_TICKS; tick++) {
        axis_real next[BENCH_STATES];
        for (int i = 0; i < AXIS_MEASURED; i++) {
            y[i] = 0;
            for (int j = 0; j < BENCH_STATES; j++)
                y[i] = y[i] + H[i][j] * x[j];
            if (tick > BENCH_TICKS - BENCH_TICKS / 10 && size(y[i] - last[i]) > moved)
                moved = size(y[i] - last[i]);
            if (tick == BENCH_TICKS - BENCH_TICKS / 10)
                last[i] = y[i];
            y[i] = counted(y[i], STEPS[i]);
        }
        if (y[0] > over)
            over = y[0];
        if (tick == 0)
            axis_start(&s, y);
        axis_step(&s, y, r, (axis_real)AXIS_TICK, u);
        for (int k = 0; k < AXIS_OUTPUTS; k++)
            if (size(u[k]) > largest)
                largest = size(u[k]);
        for (int i = 0; i < BENCH_STATES; i++) {
            next[i] = 0;
            for (int j = 0; j < BENCH_STATES; j++)
                next[i] = next[i] + F[corner][i][j] * x[j];
            for (int k = 0; k < AXIS_OUTPUTS; k++)
                next[i] = next[i] + G[corner][i][k] * u[k];
        }
        for (int i = 0; i < BENCH_STATES; i++)
            x[i] = next[i];
    }
    const int rests = moved < (axis_real)BENCH_REST;
    printf("corner %d: largest output %.6g, largest reading %.6g, last %.6g, "
           "fault %d%s\n",
        corner, (double)largest, (double)over, (double)y[0], s.fault,
        rests ? "" : ", still moving");
    return s.fault == AXIS_RUNNING && rests;
}

int main(void)
{
    const axis_real r[AXIS_ROOM(AXIS_SET_POINTS)] = BENCH_SET_POINTS;
    int good = 1;
    for (int corner = 0; corner < BENCH_CORNERS; corner++)
        good = run(corner, r) && good;
    return good ? 0 : 1;
}
