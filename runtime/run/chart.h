/* What `pkgen chart` measures of one model; see chart.c. */
#ifndef RUN_CHART_H
#define RUN_CHART_H

/* Settings from the file, requests from standard input; the process's exit code. */
int chart_run(const char *settings);

#endif
