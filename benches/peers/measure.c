/* Times whole commands, from exec to exit, in turns, so that other load of the machine affects all of them equally.
 *
 *     measure RUNS SECONDS FILE LOG -- COMMAND.. [-- COMMAND..]..
 *
 * FILE is removed before every run; the outputs of command k are appended to LOG.k. A command that has used up SECONDS
 * is not started again after its third run, and a run that lasts 10 times as long is killed. Prints one line of JSON for
 * each command: wall times in milliseconds, peak resident memory in KiB, and the exit status of the last run.
 */
#define _GNU_SOURCE
#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "scene.h"

enum { COMMANDS = 64, RUNS = 1000 };

struct command {
  char **arguments;
  double wall[RUNS], spent;
  int runs, status;
  long peak;
};

static pid_t child;
static void expire(int signal) { (void)signal, kill(child, SIGKILL); }

static void run(struct command *command, const char *file, const char *log, double seconds) {
  unlink(file);
  int output = open(log, O_WRONLY | O_CREAT | O_APPEND, 0666);
  double start = milliseconds();
  child = vfork();
  if (child == 0) {
    dup2(output, 1);
    dup2(output, 2);
    execvp(command->arguments[0], command->arguments);
    _exit(127);
  }
  struct rusage usage;
  int status;
  alarm((unsigned)(seconds * 10) + 1);
  wait4(child, &status, 0, &usage);
  double wall = milliseconds() - start;
  alarm(0);
  close(output);
  command->wall[command->runs++] = wall;
  command->spent += wall;
  command->status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  if (usage.ru_maxrss > command->peak) command->peak = usage.ru_maxrss;
}

int main(int argc, char **argv) {
  if (argc < 7) return fputs("usage: measure RUNS SECONDS FILE LOG -- COMMAND..\n", stderr), 2;
  int runs = atoi(argv[1]), count = 0;
  double seconds = atof(argv[2]);
  struct command *commands = calloc(COMMANDS, sizeof *commands);
  for (int i = 5; i < argc; i++)
    if (!strcmp(argv[i], "--")) {
      argv[i] = NULL;
      if (count == COMMANDS) fail("too many commands");
      commands[count++].arguments = argv + i + 1;
    }
  if (runs > RUNS) runs = RUNS;
  signal(SIGALRM, expire);
  for (int i = 0; i < runs; i++)
    for (int k = 0; k < count; k++) {
      struct command *c = commands + k;
      if (c->status || (c->runs >= 3 && c->spent > seconds * 1e3)) continue;
      char log[4096];
      snprintf(log, sizeof log, "%s.%d", argv[4], k);
      run(c, argv[3], log, seconds);
    }
  for (int k = 0; k < count; k++) {
    printf("{");
    print_samples("wall", commands[k].wall, commands[k].runs);
    printf(", \"peak_kib\": %ld, \"status\": %d}\n", commands[k].peak, commands[k].status);
  }
  return 0;
}
