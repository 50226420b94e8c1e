/* Failures of the system under the writer: these functions take the place of pwrite, fsync, ftruncate and
 * rename in a test that is linked with them, count the calls, and do to one of them what was asked. */
#ifndef TESTS_FAULTS_H
#define TESTS_FAULTS_H

enum fault {
    FAULT_NONE,
    FAULT_ONCE,  /* fails with an error, the calls after it do not */
    FAULT_FULL,  /* it does half of its work, if it is a write, and all after it fail */
    FAULT_SHORT, /* all writes from there on do half of their work and say so: not a failure */
    FAULT_KILL,  /* the process is killed before the call */
    FAULT_TORN   /* or after half of a write */
};

/* Count from 0 again; call number `at` fails, with `error` as errno where that applies. */
void faults_arm(enum fault fault, unsigned long at, int error);
/* Calls so far. */
unsigned long faults_calls(void);

#endif
