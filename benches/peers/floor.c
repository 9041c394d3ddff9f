/* The lower bound of the whole command: a process that only fills a file with as many bytes as the image has, in one
 * of the ways to get its pages.
 *
 *     floor WAY FILE BYTES THREADS
 *
 * WAY: truncate or reserve (how the file gets its size), then -touch (plain first touch), -populate (populate for
 * write by pieces of 2 MiB), -huge (advice for huge pages) or -write (no mapping: pwrite by pieces of 2 MiB).
 */
#define _GNU_SOURCE
#include <fcntl.h>
#include <pthread.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#ifndef MADV_POPULATE_WRITE
#define MADV_POPULATE_WRITE 23
#endif

enum { PIECE = 2 << 20 };
enum way { TOUCH, POPULATE, HUGE_PAGES, WRITE };

struct job {
  pthread_t thread;
  enum way way;
  int file;
  char *map;
  size_t first, end;
};

static void fail(const char *what) {
  perror(what);
  exit(1);
}

static void *fill(void *argument) {
  const struct job *job = argument;
  char *piece = NULL;
  if (job->way == WRITE) memset(piece = malloc(PIECE), 200, PIECE);
  for (size_t at = job->first; at < job->end; at += PIECE) {
    size_t length = job->end - at < PIECE ? job->end - at : PIECE;
    if (job->way == WRITE) {
      if (pwrite(job->file, piece, length, (off_t)at) != (ssize_t)length) fail("pwrite");
      continue;
    }
    if (job->way == POPULATE && madvise(job->map + at, length, MADV_POPULATE_WRITE)) fail("populate");
    memset(job->map + at, 200, length);
  }
  return NULL;
}

int main(int argc, char **argv) {
  if (argc != 5) return fputs("usage: floor WAY FILE BYTES THREADS\n", stderr), 2;
  size_t bytes = strtoull(argv[3], NULL, 10);
  int threads = atoi(argv[4]);
  const char *how = strchr(argv[1], '-');
  enum way way = !how ? TOUCH : !strcmp(how, "-populate") ? POPULATE : !strcmp(how, "-huge") ? HUGE_PAGES
                            : !strcmp(how, "-write")      ? WRITE
                                                          : TOUCH;
  int file = open(argv[2], O_RDWR | O_CREAT | O_TRUNC, 0666);
  if (file < 0) fail(argv[2]);
  if (argv[1][0] == 'r' ? fallocate(file, 0, 0, (off_t)bytes) : ftruncate(file, (off_t)bytes)) fail("size");
  char *map = NULL;
  if (way != WRITE) {
    map = mmap(NULL, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    if (map == MAP_FAILED) fail("map");
    if (way == HUGE_PAGES && madvise(map, bytes, MADV_HUGEPAGE)) fail("huge pages");
  }
  struct job jobs[threads];
  for (int i = 0; i < threads; i++) {
    size_t pieces = (bytes + PIECE - 1) / PIECE;
    size_t end = pieces * (size_t)(i + 1) / (size_t)threads * PIECE;
    jobs[i] = (struct job){.way = way, .file = file, .map = map,
                           .first = pieces * (size_t)i / (size_t)threads * PIECE, .end = end < bytes ? end : bytes};
    if (i && pthread_create(&jobs[i].thread, NULL, fill, &jobs[i])) fail("thread");
  }
  fill(&jobs[0]);
  for (int i = 1; i < threads; i++) pthread_join(jobs[i].thread, NULL);
  return 0;
}
