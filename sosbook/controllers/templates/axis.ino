/* axis.ino: the controller on a board that Arduino's library knows
 *
 * (Where this comes from.)
 *
 * read_sensors() and drive() are yours: put your pins there. Everything
 * else stays. A positive output must move what is measured upwards: check
 * that by hand first, with the motor free.
 */
#include "axis.h"

static axis_state state;
static axis_real set_points[AXIS_ROOM(AXIS_SET_POINTS)];
static axis_real held[AXIS_DELAY_TICKS + 1][AXIS_OUTPUTS]; /* the oldest first */
static unsigned long due, last;

/* Fill y in the units of axis_gains.h; false: there is no sample. */
static bool read_sensors(axis_real y[])
{
    for (int i = 0; i < AXIS_MEASURED; i++)
        y[i] = 0;
    return false;
}

/* Give the outputs, in the units of axis_gains.h; zeros switch off. */
static void drive(const axis_real u[])
{
    (void)u;
}

void setup()
{
    axis_real y[AXIS_MEASURED];
    Serial.begin(115200);
    while (!read_sensors(y))
        delay(10);
    axis_start(&state, y);
    for (int j = 0; j < AXIS_SET_POINTS; j++)
        set_points[j] = state.r[j];
    last = micros();
    due = last + AXIS_TICK_US;
}

void loop()
{
    axis_real y[AXIS_MEASURED], u[AXIS_OUTPUTS];
    while ((long)(micros() - due) < 0)
        ;
    const unsigned long now = micros();
    if (!read_sensors(y))
        for (int i = 0; i < AXIS_MEASURED; i++)
            y[i] = (axis_real)NAN;
    axis_step(&state, y, set_points, (axis_real)1e-6 * (axis_real)(now - last), u);
    last = now;

    /* The law knows how late it acts: so many whole ticks, and the rest. */
    for (int k = 0; k < AXIS_OUTPUTS; k++) {
        for (int age = 0; age < AXIS_DELAY_TICKS; age++)
            held[age][k] = state.fault ? 0 : held[age + 1][k];
        held[AXIS_DELAY_TICKS][k] = u[k];
    }
#if AXIS_DELAY_REST_US > 0
    while (micros() - now < AXIS_DELAY_REST_US)
        ;
#endif
    drive(held[0]);

    due += AXIS_TICK_US;
    if ((long)(micros() - due) >= 0)
        due = micros() + AXIS_TICK_US; /* never two ticks in a row to catch up */
    /* set_points[0] = ...; from wherever you take it, without waiting */
}
