/* What `accuracy` tries of one scene; see choose.c. */
#ifndef RUN_CHOOSE_H
#define RUN_CHOOSE_H

/* Settings from the file, requests from standard input; the process's exit code. */
int choose_run(const char *settings);

#endif
