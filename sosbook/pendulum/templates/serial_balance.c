/* serial_balance.c: the law on its computer, the robot in a simulator
 *
 * (Where this comes from.)
 *
 * Lines of text come in and go out; sosbook.pendulum.hardware speaks with it.
 *   s tilt wheels bias                   starts; the answer is 0 0
 *   t gyro wheels tilt target rate       a tick; the answer is volts, fault
 * On Linux: gcc -std=c99 -O2 -ffp-contract=off serial_balance.c balance.c
 *           ./a.out < /dev/ttyS0 > /dev/ttyS0
 * On a microcontroller stdin and stdout are the serial port.
 */
#include <stdio.h>
#include <stdlib.h>
#include "balance.h"

typedef double real; /* what the law computes with */

#define LONGEST 256 /* letters in a line */

/* So many numbers of a line; those that lack are zero. */
static void numbers(const char *line, double *x, int count)
{
    for (int i = 0; i < count; i++) {
        char *end;
        x[i] = strtod(line, &end);
        line = end;
    }
}

int main(void)
{
    static balance_state robot;
    char line[LONGEST];
    double x[5];
    while (fgets(line, LONGEST, stdin) != NULL) {
        double volts = 0;
        numbers(line + 1, x, 5);
        if (line[0] == 's')
            balance_start(&robot, (real)x[0], (real)x[1], (real)x[2]);
        else if (line[0] == 't')
            volts = (double)balance_step(&robot, (real)x[0], (real)x[1],
                (real)x[2], (real)x[3], (real)x[4]);
        else
            continue;
        printf("%.17g %d\n", volts, robot.fault);
        if (fflush(stdout) != 0)
            return 1;
    }
    return 0;
}
