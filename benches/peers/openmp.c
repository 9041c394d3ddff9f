/* A simple renderer: every ray against every sphere, nearest hit by inverse depth. OpenMP distributes the rows, and the
 * compiler vectorises the inner loop (-O3 -march=native).
 *
 *     openmp SCENE WIDTH HEIGHT THREADS RUNS [IMAGE]
 */
#include <math.h>
#include <omp.h>

#include "scene.h"

/* A row, `LANES` pixels at a time: the sphere loop is outside so that its loads are shared, the pixel loop is inside
 * so that the compiler can turn it into vectors. */
enum { LANES = PIXELS_PADDED };

static void draw_row(const struct scene *scene, const float *c, const float *x, float y, int width, uint8_t *row) {
  const float z = scene->viewport[2];
  for (int first = 0; first < width; first += LANES) {
    float a[LANES], best[LANES];
    int seen[LANES];
    for (int i = 0; i < LANES; i++) {
      a[i] = x[first + i] * x[first + i] + y * y + z * z;
      best[i] = 0.0f;
      seen[i] = -1;
    }
    for (unsigned k = 0; k < scene->count; k++) {
      const float *s = scene->spheres + 4 * (size_t)k;
      const float bx = s[0], yz = s[1] * y + s[2] * z, ck = c[k];
      for (int i = 0; i < LANES; i++) {
        float b = bx * x[first + i] + yz;
        float d = b * b - a[i] * ck;
        float root = sqrtf(d > 0.0f ? d : 0.0f);
        /* 1/t is (b + root)/c outside; a/(b + root) is the same number, and is right inside too. */
        float inverse = ck > 0.0f ? (b + root) / ck : a[i] / (b + root);
        int nearer = (d >= 0.0f) & (inverse > best[i]);
        best[i] = nearer ? inverse : best[i];
        seen[i] = nearer ? (int)k : seen[i];
      }
    }
    int last = width - first < LANES ? width - first : LANES;
    for (int i = 0; i < last; i++)
      memcpy(row + 3 * (first + i), seen[i] < 0 ? scene->background : scene->colours + 3 * (size_t)seen[i], 3);
  }
}

int main(int argc, char **argv) {
  if (argc < 6) fail("usage: openmp SCENE WIDTH HEIGHT THREADS RUNS [IMAGE]");
  struct scene scene = read_scene(argv[1]);
  int width = atoi(argv[2]), height = atoi(argv[3]), threads = atoi(argv[4]), runs = atoi(argv[5]);
  omp_set_num_threads(threads);
  uint8_t *rgb = (uint8_t *)malloc((size_t)width * height * 3);
  memset(rgb, 1, (size_t)width * height * 3);
  double *build = (double *)malloc(sizeof(double) * (size_t)runs), *trace = (double *)malloc(sizeof(double) * (size_t)runs);

  for (int run = -1; run < runs; run++) { /* the first run only wakes the threads */
    double start = milliseconds();
    float *x = pixel_positions(scene.viewport[0], width), *y = pixel_positions(scene.viewport[1], height);
    float *c = (float *)malloc(sizeof(float) * ((size_t)scene.count + 1));
    for (unsigned k = 0; k < scene.count; k++) {
      const float *s = scene.spheres + 4 * (size_t)k;
      c[k] = s[0] * s[0] + s[1] * s[1] + s[2] * s[2] - s[3] * s[3];
    }
    double built = milliseconds();
#pragma omp parallel for schedule(dynamic, 4)
    for (int j = 0; j < height; j++)
      draw_row(&scene, c, x, -y[j], width, rgb + (size_t)j * width * 3);
    double end = milliseconds();
    free(x), free(y), free(c);
    if (run >= 0) build[run] = built - start, trace[run] = end - built;
  }
  printf("{\"mode\": \"brute force\", ");
  print_samples("build", build, runs);
  printf(", ");
  print_samples("trace", trace, runs);
  printf("}\n");
  if (argc > 6) write_image(argv[6], rgb, width, height);
  return 0;
}
