/* The fastest inexact rasteriser of spheres that we could write: in screen space and f32, without error bounds and without
 * a rule for ties. The difference between its time and that of sfera is the cost of certainty.
 *
 *     splat SCENE WIDTH HEIGHT THREADS RUNS [IMAGE]
 *
 * Built with AVX-512 it takes 16 pixels at a time, otherwise (AVX2, FMA) 8.
 *
 *   1. Every sphere gets a box of pixels, also one that reaches the plane of the camera or contains the camera. Each run
 *      of spheres has a list for each tile of 64 x 64 pixels. A 24-byte record of each visible sphere is appended to the
 *      lists of the tiles that its box meets.
 *   2. D/c^2 and B/c are polynomials about the middle of the sphere's box in a tile. They are set up for many spheres at
 *      once.
 *   3. A tile with few spheres is drawn by masks, front to back: the columns that a sphere covers in a row are one 64-bit
 *      word. Where two spheres cover a pixel and their ranges of inverse depth in this tile overlap, the pixel is contested
 *      and the nearer sphere is found by comparing inverse depths. A tile that one sphere covers in front of all others is
 *      filled.
 *   4. A tile with many spheres is drawn into a buffer of inverse depths. If many boxes overlap, it is drawn front to back,
 *      and a sphere is left out if all blocks of 8 x 8 pixels under its box already show something nearer.
 */
#define _GNU_SOURCE
#include <immintrin.h>
#include <math.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>

#include "scene.h"

enum { TILE = 64, STRIDE = TILE + 16, CHUNK = 64, BATCH = 32, ROWS = 4, BLOCK = 8, BLOCKS = TILE / BLOCK, RUN = 1 << 16 };
enum { ORDINARY, REACHING, WITHIN }; /* in front of the camera; across its plane; containing it */

enum { FEW = 24 }; /* spheres of a tile that are drawn by masks */
enum { DEEP = 4 }; /* area of all boxes / area of the tile above which sorting and occlusion save time */

typedef struct {
  float x, y, z, r;
  uint32_t colour; /* with the kind in its highest byte */
  uint8_t left, right, top, bottom;
} Record;

/* The records of a tile are in blocks of BATCH, each with the index of the next. */
typedef struct {
  uint32_t first, end, count;
} List;

/* A part of the spheres, and its records by tile. */
typedef struct {
  int first, last;
  List *lists;
  Record *records;
  uint32_t *next;
  size_t used, room; /* in blocks */
} Run;

static int width, height, tiles_x, tiles_y, run_count, count;
static float step_x, step_y; /* difference of slope between neighbouring pixels */
static float middle_x, middle_y;
static float *xs, *ys, *zs, *rs;
static uint32_t *colours, background;
static uint8_t *image;
static Run *runs;

static void *pages(size_t bytes) {
  const size_t huge = 2 << 20;
  bytes = (bytes + huge) & ~(huge - 1);
  void *at = mmap(0, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (at == MAP_FAILED) fail("no memory");
  madvise(at, bytes, MADV_HUGEPAGE);
  return at;
}

static void unpage(void *at, size_t bytes) { munmap(at, (bytes + (2 << 20)) & ~(size_t)((2 << 20) - 1)); }

/* ---- boxes and bins ---- */

#define SLACK 0.002f
#define FAR 1e30f

/* Slopes between which a circle of radius r at (a, z) is seen, w = a^2 + z^2 - r^2. */
#define EXTENT(a, w, low, high)                                                                       \
  do {                                                                                                \
    const float root = r * sqrtf(w > 0 ? w : 0), away = fabsf(a);                                     \
    const float from = (a * z - root) / q, to = (a * z + root) / q;                                   \
    const float steep = (away - r) * (away + r) / (away * z + root), flat = (away * z - root) / q;    \
    const float edge = z >= 0 ? steep : flat;                                                         \
    low = q > 0 ? from : (w > 0) & (a > 0) ? edge : -FAR;                                             \
    high = q > 0 ? to : (w > 0) & (a < 0) ? -edge : FAR;                                              \
  } while (0)

static void find_boxes(int first, int n, float left[CHUNK], float right[CHUNK], float top[CHUNK], float bottom[CHUNK]) {
  const float ix = 1 / step_x, iy = 1 / step_y, last_x = width - 1, last_y = height - 1;
  const float *px = xs + first, *py = ys + first, *pz = zs + first, *pr = rs + first;
  for (int i = 0; i < n; i++) {
    const float x = px[i], y = py[i], z = pz[i], r = pr[i];
    const float q = (z - r) * (z + r), u = x * x + q, v = y * y + q;
    float l, h, t, b;
    EXTENT(x, u, l, h);
    EXTENT(y, v, b, t);
    l = ceilf(middle_x + l * ix - SLACK), h = floorf(middle_x + h * ix + SLACK);
    t = ceilf(middle_y - t * iy - SLACK), b = floorf(middle_y - b * iy + SLACK);
    left[i] = l < 0 ? 0 : l, right[i] = z + r > 0 ? (h > last_x ? last_x : h) : -1;
    top[i] = t < 0 ? 0 : t, bottom[i] = b > last_y ? last_y : b;
  }
}

static void grow(Run *run) {
  const size_t room = 2 * run->room + 4096;
  Record *records = pages(room * BATCH * sizeof *records);
  uint32_t *next = realloc(run->next, room * sizeof *next);
  if (!next) fail("no memory");
  if (run->room) {
    memcpy(records, run->records, run->used * BATCH * sizeof *records);
    unpage(run->records, run->room * BATCH * sizeof *records);
  }
  run->records = records, run->next = next, run->room = room;
}

static inline void append(Run *run, List *list, const Record *record) {
  if (list->end % BATCH == 0) {
    if (run->used == run->room) grow(run);
    const uint32_t block = run->used++;
    if (list->count) run->next[list->end / BATCH - 1] = block;
    else list->first = block;
    list->end = block * BATCH;
  }
  run->records[list->end] = *record;
  /* The end of a full block is the first index of the block behind it. */
  list->end++, list->count++;
}

static void bin(Run *run) {
  memset(run->lists, 0, sizeof *run->lists * tiles_x * tiles_y);
  run->used = 0;
  for (int first = run->first; first < run->last; first += CHUNK) {
    float left[CHUNK], right[CHUNK], top[CHUNK], bottom[CHUNK];
    const int n = run->last - first < CHUNK ? run->last - first : CHUNK;
    find_boxes(first, n, left, right, top, bottom);
    for (int i = 0; i < n; i++) {
      if (!(left[i] <= right[i] && top[i] <= bottom[i])) continue;
      const int k = first + i, l = left[i], r = right[i], t = top[i], b = bottom[i];
      const float x = xs[k], y = ys[k], z = zs[k];
      const int kind = z > rs[k] ? ORDINARY : (x * x + y * y) + (z - rs[k]) * (z + rs[k]) > 0 ? REACHING : WITHIN;
      Record record = { x, y, z, rs[k], colours[k] | (uint32_t)kind << 24, l % TILE, r % TILE, t % TILE, b % TILE };
      const int tile = t / TILE * tiles_x + l / TILE;
      if (l / TILE == r / TILE && t / TILE == b / TILE) {
        append(run, run->lists + tile, &record);
        continue;
      }
      for (int j = t / TILE; j <= b / TILE; j++)
        for (int i = l / TILE; i <= r / TILE; i++) {
          record.left = i == l / TILE ? l % TILE : 0, record.right = i == r / TILE ? r % TILE : TILE - 1;
          record.top = j == t / TILE ? t % TILE : 0, record.bottom = j == b / TILE ? b % TILE : TILE - 1;
          append(run, run->lists + j * tiles_x + i, &record);
        }
    }
  }
}

/* ---- a tile ---- */

typedef struct {
  /* With room for ROWS and LANES behind the tile. */
  float depths[(TILE + ROWS) * STRIDE] __attribute__((aligned(64)));
  uint32_t colours[(TILE + ROWS) * STRIDE] __attribute__((aligned(64)));
  uint64_t masks[FEW][TILE] __attribute__((aligned(64)));
  uint64_t covered[TILE], contested[TILE + 8] __attribute__((aligned(64)));
  /* For each of up to CHUNK spheres: the fields of its record; */
  float x[CHUNK], y[CHUNK], z[CHUNK], r[CHUNK];
  float left[CHUNK], right[CHUNK], top[CHUNK], bottom[CHUNK];
  uint32_t colour[CHUNK];
  float within[CHUNK]; /* 1 if it contains the camera */
  int kind[CHUNK];
  /* the polynomials in the pixel's offset from the middle of the box; */
  float mx[CHUNK], my[CHUNK], X[CHUNK], Y[CHUNK], c[CHUNK];
  float d00[CHUNK], d10[CHUNK], d01[CHUNK], d20[CHUNK], d11[CHUNK], d02[CHUNK], b00[CHUNK], b10[CHUNK], b01[CHUNK];
  /* by row from the top of the tile: the square of half the width in columns, and the middle column; */
  float e0[CHUNK], e1[CHUNK], e2[CHUNK], m0[CHUNK], m1[CHUNK];
  /* the bounds of its inverse depth. */
  float lower[CHUNK + 16], upper[CHUNK + 16];
  uint8_t bl[CHUNK], br[CHUNK], bt[CHUNK], bb[CHUNK];
  float inside[CHUNK], covers[CHUNK];
  float farthest[BLOCKS * BLOCKS];
  uint8_t stale[BLOCKS * BLOCKS];
  const Record **order, **sorted;
  float *uppers;
  size_t room;
} Work;

static void take(Work *w, int i, const Record *s) {
  w->x[i] = s->x, w->y[i] = s->y, w->z[i] = s->z, w->r[i] = s->r;
  w->left[i] = s->left, w->right[i] = s->right, w->top[i] = s->top, w->bottom[i] = s->bottom;
  w->colour[i] = s->colour & 0xffffff;
  w->kind[i] = s->colour >> 24;
  w->within[i] = w->kind[i] == WITHIN;
}

/* D and B as polynomials, divided by c^2 and c if the camera is outside the sphere. In floats for many spheres. In doubles
 * for few, because in floats only a few digits are right of a sphere that is large compared with the picture. */
#define SET_UP(name, real)                                                                                                       \
  static void name(Work *restrict w, int n, int x0, int y0) {                                                                    \
    const real dx = step_x, dy = -step_y;                                                                                        \
    for (int i = 0; i < n; i++) {                                                                                                \
      const real x = w->x[i], y = w->y[i], z = w->z[i], r = w->r[i], rr = r * r;                                                 \
      const real mx = truncf((w->left[i] + w->right[i]) * .5f), my = truncf((w->top[i] + w->bottom[i]) * .5f);                   \
      const real X = (x0 + mx - middle_x) * dx, Y = (y0 + my - middle_y) * dy;                                                   \
      const real k = y * y + (z - r) * (z + r), c = x * x + k, ic = w->within[i] > 0 ? 1 : 1 / c, cc = ic * ic;                  \
      const real nx = y - z * Y, ny = z * X - x, nz = x * Y - y * X;                                                             \
      w->mx[i] = mx, w->my[i] = my, w->X[i] = X, w->Y[i] = Y, w->c[i] = c;                                                       \
      w->d00[i] = (rr * (X * X + Y * Y + 1) - nx * nx - ny * ny - nz * nz) * cc;                                                 \
      w->d10[i] = 2 * (rr * X - ny * z + nz * y) * dx * cc, w->d01[i] = 2 * (rr * Y + nx * z - nz * x) * dy * cc;                \
      w->d20[i] = -k * dx * dx * cc, w->d11[i] = 2 * x * y * dx * dy * cc, w->d02[i] = (rr - x * x - z * z) * dy * dy * cc;      \
      w->b00[i] = (x * X + y * Y + z) * ic, w->b10[i] = x * dx * ic, w->b01[i] = y * dy * ic;                                    \
    }                                                                                                                            \
  }
SET_UP(set_up_many, float)
SET_UP(set_up_few, double)

/* The other terms of masks: the ends of rows, in doubles, and the ranges of inverse depth in the tile. */
static void set_up_ends(Work *restrict w, int n, int x0, int y0) {
  const double dy = -step_y, sx = 1 / (double)step_x;
  for (int i = 0; i < n; i++) {
    const double x = w->x[i], y = w->y[i], z = w->z[i], r = w->r[i], rr = r * r, Y = (y0 - (double)middle_y) * dy;
    const double ik = 1 / (y * y + (z - r) * (z + r)), c = x * x + y * y + (z - r) * (z + r);
    const double N0 = y - z * Y, N1 = -z * dy, lean = x * sx * ik, h = c * sx * sx * ik * ik;
    w->e0[i] = h * (rr * (Y * Y + 1) - N0 * N0), w->e1[i] = h * 2 * (rr * Y * dy - N0 * N1), w->e2[i] = h * (rr * dy * dy - N1 * N1);
    w->m0[i] = middle_x - x0 + lean * (y * Y + z), w->m1[i] = lean * y * dy;
  }
}

static void set_up_ranges(Work *restrict w, int n, int last_x, int last_y) {
  const float dx = step_x, dy = -step_y;
  for (int i = 0; i < n; i++) {
    const float x = w->x[i], y = w->y[i], z = w->z[i], r = w->r[i], within = w->within[i], c = w->c[i];
    const float l = w->left[i] - w->mx[i], h = w->right[i] - w->mx[i], t = w->top[i] - w->my[i], b = w->bottom[i] - w->my[i];
    float lowest = FAR, highest = 0, inside = 1;
#define CORNER(p, q)                                                                                                        \
  do {                                                                                                                      \
    const float d = w->d00[i] + p * (w->d10[i] + p * w->d20[i] + q * w->d11[i]) + q * (w->d01[i] + q * w->d02[i]);          \
    const float m = w->b00[i] + p * w->b10[i] + q * w->b01[i], root = sqrtf(d > 0 ? d : 0);                                 \
    const float X = w->X[i] + p * dx, Y = w->Y[i] + q * dy;                                                                 \
    const float s = within > 0 ? (1 + X * X + Y * Y) / (m + root) : m + root;                                               \
    inside = (d > 0) & ((m > 0) | (within > 0)) ? inside : 0;                                                               \
    lowest = s < lowest ? s : lowest, highest = s > highest ? s : highest;                                                  \
  } while (0)
    CORNER(l, t);
    CORNER(h, t);
    CORNER(l, b);
    CORNER(h, b);
    /* The tangent plane at the middle is the bound on the other side. */
    const float root = sqrtf(w->d00[i] > 0 ? w->d00[i] : 0), m = w->b00[i], X = w->X[i], Y = w->Y[i];
    const float s = within > 0 ? (1 + X * X + Y * Y) / (m + root) : m + root, half = .5f / root;
    const float gx = within > 0 ? (2 * X * dx - 2 * s * w->b10[i]) * half : w->b10[i] + w->d10[i] * half;
    const float gy = within > 0 ? (2 * Y * dy - 2 * s * w->b01[i]) * half : w->b01[i] + w->d01[i] * half;
    const float far_x = h > -l ? h : -l, far_y = b > -t ? b : -t, change = fabsf(gx) * far_x + fabsf(gy) * far_y;
    const float plane = w->d00[i] > 0 ? s + change : FAR, cap = z > r ? 1 / (z - r) : FAR;
    const float cr = sqrtf(c > 0 ? c : 0), rim = (x * x + y * y + z * z) / (cr * (cr * z + r * sqrtf(x * x + y * y)));
    const float low = within > 0 ? s - change : inside > 0 ? lowest : z > r ? rim : 0;
    const float high = within > 0 ? highest : plane < cap ? plane : cap;
    w->lower[i] = low * .99999f, w->upper[i] = high * 1.00001f;
    w->inside[i] = inside;
    w->covers[i] = (inside > 0) & (w->left[i] == 0) & (w->top[i] == 0) & (w->right[i] == last_x) & (w->bottom[i] == last_y) ? 1 : 0;
  }
}

#ifdef __AVX512F__
typedef __m512 Floats;
typedef __mmask16 Lanes;
enum { LANES = 16 };
#define all(v) _mm512_set1_ps(v)
#define fma(a, b, c) _mm512_fmadd_ps(a, b, c)
#define add(a, b) _mm512_add_ps(a, b)
#define divide(a, b) _mm512_div_ps(a, b)
#define root(a) _mm512_sqrt_ps(a)
#define load(at) _mm512_loadu_ps(at)
#define greater(a, b) _mm512_cmp_ps_mask(a, b, _CMP_GT_OQ)
#define both(a, b) ((a) & (b))
#define lanes_of(bits) ((__mmask16)(bits))
#define bits_of(lanes) ((uint64_t)(lanes))
#define store(at, lanes, v) _mm512_mask_storeu_ps(at, lanes, v)
#define store_colour(at, lanes, v) _mm512_mask_storeu_epi32(at, lanes, _mm512_set1_epi32(v))
#define STEPS _mm512_setr_ps(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15)
#else
typedef __m256 Floats;
typedef __m256 Lanes;
enum { LANES = 8 };
#define all(v) _mm256_set1_ps(v)
#define fma(a, b, c) _mm256_fmadd_ps(a, b, c)
#define add(a, b) _mm256_add_ps(a, b)
#define divide(a, b) _mm256_div_ps(a, b)
#define root(a) _mm256_sqrt_ps(a)
#define load(at) _mm256_loadu_ps(at)
#define greater(a, b) _mm256_cmp_ps(a, b, _CMP_GT_OQ)
#define both(a, b) _mm256_and_ps(a, b)
static inline __m256 lanes_of(uint64_t bits) {
  const __m256i each = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
  return _mm256_castsi256_ps(_mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32((int)bits), each), each));
}
#define bits_of(lanes) ((uint64_t)_mm256_movemask_ps(lanes))
/* Not a masked store, which is slow on some CPUs. Every row has room behind it. */
#define store(at, lanes, v) _mm256_storeu_ps(at, _mm256_blendv_ps(_mm256_loadu_ps(at), v, lanes))
#define store_colour(at, lanes, v) \
  _mm256_storeu_ps((float *)(at), _mm256_blendv_ps(_mm256_loadu_ps((float *)(at)), _mm256_castsi256_ps(_mm256_set1_epi32(v)), lanes))
#define STEPS _mm256_setr_ps(0, 1, 2, 3, 4, 5, 6, 7)
#endif

/* The polynomials of a sphere in one row. */
typedef struct {
  Floats d0, d1, d2, b0, b1;
  float q;
} Row;

static inline Row row_of(const Work *w, int i, int j) {
  const float q = j - w->my[i];
  return (Row){ all(w->d00[i] + q * (w->d01[i] + q * w->d02[i])), all(w->d10[i] + q * w->d11[i]), all(w->d20[i]),
                all(w->b00[i] + q * w->b01[i]), all(w->b10[i]), q };
}

/* Inverse depth at some pixels of a row; 0, less or NaN where the sphere is not hit. */
static inline Floats depth_at(const Work *w, int i, const Row *row, int kind, float from) {
  const Floats p = add(STEPS, all(from - w->mx[i]));
  const Floats d = fma(p, fma(p, row->d2, row->d1), row->d0), b = fma(p, row->b1, row->b0), sum = add(b, root(d));
  if (kind == ORDINARY) return sum;
  const Floats zero = all(0.f);
  if (kind == REACHING) {
#ifdef __AVX512F__
    return _mm512_mask_mov_ps(zero, greater(b, zero), sum);
#else
    return _mm256_and_ps(greater(b, zero), sum);
#endif
  }
  const Floats X = fma(p, all(step_x), all(w->X[i]));
  const float Y = w->Y[i] - row->q * step_y;
  return divide(fma(X, X, all(1 + Y * Y)), sum);
}

static inline void keep_nearer(float *z, uint32_t *out, __m256 s, __m256i colour) {
#ifdef __AVX512VL__
  const __mmask8 nearer = _mm256_cmp_ps_mask(s, _mm256_loadu_ps(z), _CMP_GT_OQ);
  _mm256_mask_storeu_ps(z, nearer, s);
  _mm256_mask_storeu_epi32(out, nearer, colour);
#else
  const __m256 before = _mm256_loadu_ps(z), nearer = _mm256_cmp_ps(s, before, _CMP_GT_OQ);
  _mm256_storeu_ps(z, _mm256_blendv_ps(before, s, nearer));
  _mm256_storeu_ps((float *)out, _mm256_blendv_ps(_mm256_loadu_ps((float *)out), _mm256_castsi256_ps(colour), nearer));
#endif
}

/* Draws an ordinary sphere of at most 8 columns, ROWS rows at a time. In the rows behind its box it has no pixels; a fixed
 * number of rows is faster, because the CPU need not predict where the loop ends. */
static inline void meet_narrow(Work *w, int i) {
  const int left = w->left[i], top = w->top[i], bottom = w->bottom[i];
  const __m256 p = _mm256_add_ps(_mm256_setr_ps(0, 1, 2, 3, 4, 5, 6, 7), _mm256_set1_ps(left - w->mx[i]));
  const __m256 d2 = _mm256_set1_ps(w->d20[i]), b = _mm256_fmadd_ps(p, _mm256_set1_ps(w->b10[i]), _mm256_set1_ps(w->b00[i]));
  const __m256 d = _mm256_fmadd_ps(p, _mm256_fmadd_ps(p, d2, _mm256_set1_ps(w->d10[i])), _mm256_set1_ps(w->d00[i]));
  const __m256 t = _mm256_fmadd_ps(p, _mm256_set1_ps(w->d11[i]), _mm256_set1_ps(w->d01[i])), d02 = _mm256_set1_ps(w->d02[i]);
  const __m256 b01 = _mm256_set1_ps(w->b01[i]), one = _mm256_set1_ps(1);
  const __m256i colour = _mm256_set1_epi32(w->colour[i]);
  __m256 q = _mm256_set1_ps(top - w->my[i]);
  float *z = w->depths + top * STRIDE + left;
  uint32_t *out = w->colours + top * STRIDE + left;
  for (int j = top; j <= bottom; j += ROWS)
    for (int k = 0; k < ROWS; k++, z += STRIDE, out += STRIDE, q = _mm256_add_ps(q, one)) {
      const __m256 root = _mm256_sqrt_ps(_mm256_fmadd_ps(q, _mm256_fmadd_ps(q, d02, t), d));
      keep_nearer(z, out, _mm256_add_ps(_mm256_fmadd_ps(q, b01, b), root), colour);
    }
}

static inline void meet(Work *w, int i, int kind) {
  const int left = w->left[i], right = w->right[i], top = w->top[i], bottom = w->bottom[i];
  const uint32_t colour = w->colour[i];
  for (int j = top; j <= bottom; j++) {
    const Row row = row_of(w, i, j);
    float *z = w->depths + j * STRIDE;
    uint32_t *out = w->colours + j * STRIDE;
    for (int from = left; from <= right; from += LANES) {
      const Floats s = depth_at(w, i, &row, kind, from);
      const Lanes nearer = greater(s, load(z + from));
      store(z + from, nearer, s);
      store_colour(out + from, nearer, colour);
    }
  }
}

static void meet_any(Work *w, int i) {
  if (w->kind[i] == ORDINARY && w->right[i] - w->left[i] < 8) meet_narrow(w, i);
  else if (w->kind[i] == ORDINARY) meet(w, i, ORDINARY);
  else if (w->kind[i] == REACHING) meet(w, i, REACHING);
  else meet(w, i, WITHIN);
}

/* ---- many spheres: a buffer of depths ---- */

static inline float upper_of(const Record *s) { return s->z > s->r ? 1 / (s->z - s->r) : FAR; }

/* Sorts front to back by upper bound of inverse depth, in 1024 steps. */
static void sort(Work *w, int n) {
  enum { STEPS_OF_DEPTH = 1024 };
  uint32_t starts[STEPS_OF_DEPTH + 1] = { 0 };
  float low = FAR, high = 0;
  for (int i = 0; i < n; i++) {
    const float upper = w->uppers[i] = upper_of(w->order[i]);
    low = upper < low ? upper : low, high = upper > high && upper < FAR ? upper : high;
  }
  const float scale = high > low ? (STEPS_OF_DEPTH - 1) / (high - low) : 0;
#define PLACE(upper) (upper >= high ? 0 : STEPS_OF_DEPTH - 1 - (int)((upper - low) * scale))
  for (int i = 0; i < n; i++) starts[PLACE(w->uppers[i]) + 1]++;
  for (int i = 0; i < STEPS_OF_DEPTH; i++) starts[i + 1] += starts[i];
  for (int i = 0; i < n; i++) w->sorted[starts[PLACE(w->uppers[i])]++] = w->order[i];
  const Record **swap = w->order;
  w->order = w->sorted, w->sorted = swap;
}

static float farthest_of(const Work *w, int block) {
  const float *z = w->depths + block / BLOCKS * BLOCK * STRIDE + block % BLOCKS * BLOCK;
  __m256 lower = _mm256_loadu_ps(z);
  for (int j = 1; j < BLOCK; j++) lower = _mm256_min_ps(lower, _mm256_loadu_ps(z + j * STRIDE));
  __m128 half = _mm_min_ps(_mm256_castps256_ps128(lower), _mm256_extractf128_ps(lower, 1));
  half = _mm_min_ps(half, _mm_movehl_ps(half, half));
  return _mm_cvtss_f32(_mm_min_ss(half, _mm_shuffle_ps(half, half, 1)));
}

/* Whether all pixels of a sphere's box show something nearer. */
static int hidden(Work *w, const Record *s) {
  const float upper = upper_of(s);
  for (int y = s->top / BLOCK; y <= s->bottom / BLOCK; y++)
    for (int x = s->left / BLOCK; x <= s->right / BLOCK; x++) {
      const int block = y * BLOCKS + x;
      if (w->farthest[block] > upper) continue;
      if (!w->stale[block]) return 0;
      w->farthest[block] = farthest_of(w, block), w->stale[block] = 0;
      if (w->farthest[block] <= upper) return 0;
    }
  return 1;
}

static void draw_many(Work *w, int n, int x0, int y0) {
  memset(w->depths, 0, sizeof w->depths);
  for (int i = 0; i < TILE * STRIDE; i++) w->colours[i] = background;
  int area = 0;
  for (int i = 0; i < n; i++) {
    const Record *s = w->order[i];
    area += (s->right - s->left + 1) * (s->bottom - s->top + 1);
  }
  const int deep = area > DEEP * TILE * TILE;
  if (deep) {
    sort(w, n);
    memset(w->farthest, 0, sizeof w->farthest), memset(w->stale, 0, sizeof w->stale);
  }
  for (int at = 0; at < n;) {
    int taken = 0;
    /* Few at a time if they may hide each other. */
    const int limit = deep ? 16 : CHUNK;
    for (; at < n && taken < limit; at++) {
      const Record *s = w->order[at];
      if (!deep || !hidden(w, s)) take(w, taken++, s);
    }
    set_up_many(w, taken, x0, y0);
    for (int i = 0; i < taken; i++) meet_any(w, i);
    if (deep)
      for (int i = 0; i < taken; i++)
        for (int y = (int)w->top[i] / BLOCK; y <= (int)w->bottom[i] / BLOCK; y++)
          for (int x = (int)w->left[i] / BLOCK; x <= (int)w->right[i] / BLOCK; x++) w->stale[y * BLOCKS + x] = 1;
  }
}

/* ---- few spheres: masks ---- */

/* The columns of an ordinary sphere, 8 rows at a time from a multiple of 8. */
static void find_masks(const Work *w, int i, uint64_t *masks) {
  const __m256 zero = _mm256_setzero_ps(), whole = _mm256_set1_ps(TILE), one = _mm256_set1_ps(1);
  for (int j = (int)w->top[i] & ~7; j <= w->bottom[i]; j += 8) {
    const __m256 q = _mm256_add_ps(_mm256_setr_ps(0, 1, 2, 3, 4, 5, 6, 7), _mm256_set1_ps(j));
    const __m256 e = _mm256_fmadd_ps(q, _mm256_fmadd_ps(q, _mm256_set1_ps(w->e2[i]), _mm256_set1_ps(w->e1[i])), _mm256_set1_ps(w->e0[i]));
    const __m256 half = _mm256_sqrt_ps(_mm256_max_ps(e, zero)), middle = _mm256_fmadd_ps(q, _mm256_set1_ps(w->m1[i]), _mm256_set1_ps(w->m0[i]));
    __m256 l = _mm256_ceil_ps(_mm256_sub_ps(middle, half)), t = _mm256_add_ps(_mm256_floor_ps(_mm256_add_ps(middle, half)), one);
    l = _mm256_min_ps(_mm256_max_ps(l, zero), whole), t = _mm256_min_ps(_mm256_max_ps(t, zero), whole);
    const __m256i from = _mm256_cvttps_epi32(l), to = _mm256_cvttps_epi32(t);
    /* Without any column, end = from. */
    const __m256i end = _mm256_blendv_epi8(from, to, _mm256_castps_si256(_mm256_cmp_ps(e, zero, _CMP_GE_OQ)));
#ifdef __AVX512F__
    const __m512i ones = _mm512_set1_epi64(-1);
    _mm512_store_si512(masks + j, _mm512_andnot_si512(_mm512_sllv_epi64(ones, _mm512_cvtepi32_epi64(end)), _mm512_sllv_epi64(ones, _mm512_cvtepi32_epi64(from))));
#else
    const __m256i ones = _mm256_set1_epi64x(-1);
    for (int k = 0; k < 2; k++) {
      const __m256i f = _mm256_cvtepi32_epi64(k ? _mm256_extracti128_si256(from, 1) : _mm256_castsi256_si128(from));
      const __m256i g = _mm256_cvtepi32_epi64(k ? _mm256_extracti128_si256(end, 1) : _mm256_castsi256_si128(end));
      _mm256_store_si256((__m256i *)(masks + j + 4 * k), _mm256_andnot_si256(_mm256_sllv_epi64(ones, g), _mm256_sllv_epi64(ones, f)));
    }
#endif
  }
}

/* The same for other kinds of spheres, pixel by pixel. */
static void find_masks_by_pixel(const Work *w, int i, uint64_t *masks) {
  const int left = w->left[i], right = w->right[i];
  for (int j = (int)w->top[i] & ~7; j <= ((int)w->bottom[i] | 7); j++) {
    masks[j] = 0;
    if (j < w->top[i] || j > w->bottom[i]) continue;
    const Row row = row_of(w, i, j);
    for (int from = left & ~(LANES - 1); from <= right; from += LANES)
      masks[j] |= bits_of(greater(depth_at(w, i, &row, w->kind[i], from), all(0.f))) << from;
    masks[j] &= ~0ull << left & ~0ull >> (63 - right);
  }
}

/* A bit for each of the first n values: whether it is less than `than`. Later bits are undefined. */
static inline uint64_t less(const float *values, int n, float than) {
  uint64_t bits = 0;
  for (int o = 0; o < n; o += LANES) bits |= bits_of(greater(all(than), load(values + o))) << o;
  return bits;
}

static inline uint64_t boxes_at(const Work *w, int i) {
#ifdef __AVX512BW__
#define AT(a) _mm512_loadu_si512(a)
#define OF(a) _mm512_set1_epi8(a)
  return _mm512_cmple_epu8_mask(AT(w->bl), OF(w->br[i])) & _mm512_cmpge_epu8_mask(AT(w->br), OF(w->bl[i])) &
         _mm512_cmple_epu8_mask(AT(w->bt), OF(w->bb[i])) & _mm512_cmpge_epu8_mask(AT(w->bb), OF(w->bt[i]));
#else
  uint64_t apart = 0;
  for (int o = 0; o < 64; o += 32) { /* the bytes are below 64, so signed comparison is right */
#define AT(a) _mm256_loadu_si256((const __m256i *)(a + o))
#define OF(a) _mm256_set1_epi8(a)
    const __m256i a = _mm256_or_si256(_mm256_cmpgt_epi8(AT(w->bl), OF(w->br[i])), _mm256_cmpgt_epi8(OF(w->bl[i]), AT(w->br)));
    const __m256i b = _mm256_or_si256(_mm256_cmpgt_epi8(AT(w->bt), OF(w->bb[i])), _mm256_cmpgt_epi8(OF(w->bt[i]), AT(w->bb)));
    apart |= (uint64_t)(uint32_t)_mm256_movemask_epi8(_mm256_or_si256(a, b)) << o;
  }
  return ~apart;
#endif
}

static inline void paint(uint32_t *row, uint64_t visible, uint32_t colour) {
#ifdef __AVX512F__
  for (int from = __builtin_ctzll(visible) & ~15; from < TILE && visible >> from; from += 16) store_colour(row + from, (__mmask16)(visible >> from), colour);
#else
  const __m256i c = _mm256_set1_epi32(colour);
  while (visible) { /* a run of columns at a time */
    const int from = __builtin_ctzll(visible);
    const uint64_t rest = ~(visible >> from);
    const int n = rest ? __builtin_ctzll(rest) : 64;
    uint32_t *at = row + from;
    if (n >= 8) {
      for (int i = 0; i + 8 <= n; i += 8) _mm256_storeu_si256((__m256i *)(at + i), c);
      _mm256_storeu_si256((__m256i *)(at + n - 8), c);
    } else {
      store_colour(at, lanes_of((1u << n) - 1), colour);
    }
    visible = from + n < 64 ? visible & ~0ull << (from + n) : 0;
  }
#endif
}

/* Takes the spheres of a tile front to back. */
static void arrange(Work *w, int n) {
  float keys[CHUNK + 16] __attribute__((aligned(64)));
  const Record *by_rank[CHUNK];
  for (int i = 0; i < n; i++) keys[i] = -upper_of(w->order[i]);
  for (int i = 0; i < n; i++) {
    const uint64_t before = less(keys, n, keys[i]), upto = less(keys, n, nextafterf(keys[i], FAR * 2)) & ~before;
    const uint64_t valid = n < 64 ? (1ull << n) - 1 : ~0ull;
    by_rank[__builtin_popcountll(before & valid) + __builtin_popcountll(upto & ((1ull << i) - 1))] = w->order[i];
  }
  for (int i = 0; i < n; i++) {
    const Record *s = by_rank[i];
    take(w, i, s);
    w->bl[i] = s->left, w->br[i] = s->right, w->bt[i] = s->top, w->bb[i] = s->bottom;
  }
}

/* Marks the pixels that sphere i shares with an earlier one if their inverse depths overlap. */
static int contest(Work *w, int i) {
  uint64_t near = less(w->lower, i, w->upper[i]) & boxes_at(w, i);
  near &= (1ull << i) - 1;
  int any = 0;
  for (; near; near &= near - 1) {
    const int other = __builtin_ctzll(near);
    const int top = w->bt[other] > w->bt[i] ? w->bt[other] : w->bt[i], bottom = w->bb[other] < w->bb[i] ? w->bb[other] : w->bb[i];
    uint64_t sum = 0;
    for (int j = top; j <= bottom; j++) {
      const uint64_t shared = w->masks[other][j] & w->masks[i][j];
      w->contested[j] |= shared, sum |= shared;
    }
    any |= sum != 0;
  }
  return any;
}

static void settle_contests(Work *w, int n, int h) {
  for (int j = 0; j < h; j++)
    if (w->contested[j]) memset(w->depths + j * STRIDE, 0, TILE * sizeof(float));
  for (int i = 0; i < n; i++)
    for (int j = w->top[i]; j <= w->bottom[i]; j++) {
      const uint64_t shared = w->masks[i][j] & w->contested[j];
      if (!shared) continue;
      const Row row = row_of(w, i, j);
      float *z = w->depths + j * STRIDE;
      uint32_t *out = w->colours + j * STRIDE;
      for (int from = __builtin_ctzll(shared) & ~(LANES - 1); from < 64 && shared >> from; from += LANES) {
        const uint64_t bits = shared >> from & ((1ull << LANES) - 1);
        if (!bits) continue;
        const Floats s = depth_at(w, i, &row, w->kind[i], from);
        const Lanes nearer = both(greater(s, load(z + from)), lanes_of(bits));
        store(z + from, nearer, s);
        store_colour(out + from, nearer, w->colour[i]);
      }
    }
}

/* Draws a tile; if it has only one colour, returns 1 and that colour. */
static int draw_few(Work *w, int n, int x0, int y0, int last_x, int last_y, uint32_t *colour) {
  arrange(w, n);
  set_up_few(w, n, x0, y0);
  set_up_ranges(w, n, last_x, last_y);
  float wall = 0;
  int behind = -1, ordinary = 0;
  for (int i = 0; i < n; i++)
    if (w->covers[i] > 0 && w->lower[i] > wall) wall = w->lower[i], behind = i;
  if (behind >= 0) {
    int seen = 0;
    for (int i = 0; i < n; i++) seen += i == behind || w->upper[i] > wall;
    if (seen == 1) return *colour = w->colour[behind], 1;
  }
  for (int i = 0; i < n; i++) ordinary += w->kind[i] == ORDINARY;
  if (ordinary) set_up_ends(w, n, x0, y0);
  memset(w->covered, 0, sizeof w->covered);
  memset(w->contested, 0, sizeof w->contested);
  int contested = 0;
  for (int i = 0; i < n; i++) {
    uint64_t *masks = w->masks[i];
    if (w->upper[i] < wall && i != behind) { /* hidden; it contests nothing */
      w->lower[i] = FAR, w->top[i] = 1, w->bottom[i] = 0;
      continue;
    }
    if (w->inside[i] > 0) {
      const uint64_t columns = ~0ull << w->bl[i] & ~0ull >> (63 - w->br[i]);
      for (int j = (int)w->top[i] & ~7; j <= ((int)w->bottom[i] | 7); j++) masks[j] = columns;
    } else if (w->kind[i] == ORDINARY) find_masks(w, i, masks);
    else find_masks_by_pixel(w, i, masks);
    if (i) contested |= contest(w, i);
    const int bottom = w->bottom[i];
    for (int j = w->top[i]; j <= bottom; j++) {
      const uint64_t visible = masks[j] & ~w->covered[j];
      if (!visible) continue;
      w->covered[j] |= visible;
      paint(w->colours + j * STRIDE, visible, w->colour[i]);
    }
  }
  for (int j = 0; j <= last_y; j++)
    if (~w->covered[j]) paint(w->colours + j * STRIDE, ~w->covered[j], background);
  if (contested) settle_contests(w, n, last_y + 1);
  return 0;
}

/* ---- bytes ---- */

#ifdef __AVX512VBMI__
/* For the bytes of three lines: their places in two vectors of pixels. */
static uint8_t places[192] __attribute__((aligned(64)));
#endif

static void pack(const Work *w, int x0, int y0, int n, int h) {
  for (int j = 0; j < h; j++) {
    uint8_t *out = image + ((size_t)(y0 + j) * width + x0) * 3;
    const uint32_t *in = w->colours + j * STRIDE;
    int i = 0;
#ifdef __AVX512VBMI__
    if (n == TILE) { /* three whole lines */
      const __m512i a = _mm512_load_si512(in), b = _mm512_load_si512(in + 16), c = _mm512_load_si512(in + 32), d = _mm512_load_si512(in + 48);
      _mm512_storeu_si512(out, _mm512_permutex2var_epi8(a, _mm512_load_si512(places), b));
      _mm512_storeu_si512(out + 64, _mm512_permutex2var_epi8(b, _mm512_load_si512(places + 64), c));
      _mm512_storeu_si512(out + 128, _mm512_permutex2var_epi8(c, _mm512_load_si512(places + 128), d));
      continue;
    }
    for (; i < n; i += 16) {
      const int left = n - i < 16 ? n - i : 16;
      _mm512_mask_storeu_epi8(out + 3 * i, ~0ull >> (64 - 3 * left), _mm512_permutexvar_epi8(_mm512_load_si512(places), _mm512_loadu_si512(in + i)));
    }
#else
    const __m256i drop = _mm256_broadcastsi128_si256(_mm_setr_epi8(0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14, -1, -1, -1, -1));
    for (; i + 8 <= n; i += 8) {
      const __m256i words = _mm256_shuffle_epi8(_mm256_loadu_si256((const __m256i *)(in + i)), drop);
      const __m256i bytes = _mm256_permutevar8x32_epi32(words, _mm256_setr_epi32(0, 1, 2, 4, 5, 6, 7, 7));
      _mm_storeu_si128((__m128i *)(out + 3 * i), _mm256_castsi256_si128(bytes));
      _mm_storel_epi64((__m128i *)(out + 3 * i + 16), _mm256_extracti128_si256(bytes, 1));
    }
    for (; i < n; i++) out[3 * i] = in[i], out[3 * i + 1] = in[i] >> 8, out[3 * i + 2] = in[i] >> 16;
#endif
  }
}

static void fill(uint32_t colour, int x0, int y0, int n, int h) {
  uint8_t row[3 * TILE];
  for (int i = 0; i < n; i++) row[3 * i] = colour, row[3 * i + 1] = colour >> 8, row[3 * i + 2] = colour >> 16;
  for (int j = 0; j < h; j++) {
    uint8_t *out = image + ((size_t)(y0 + j) * width + x0) * 3;
    if (n == TILE) memcpy(out, row, 3 * TILE);
    else memcpy(out, row, 3 * n);
  }
}

static void draw(Work *w, int tile) {
  const int x0 = tile % tiles_x * TILE, y0 = tile / tiles_x * TILE;
  const int right = width - x0 < TILE ? width - x0 : TILE, h = height - y0 < TILE ? height - y0 : TILE;
  size_t n = 0;
  for (int k = 0; k < run_count; k++) n += runs[k].lists[tile].count;
  uint32_t colour = background;
  int uniform = !n;
  if (n > w->room) {
    free(w->order), free(w->sorted), free(w->uppers);
    w->room = 2 * n;
    w->order = malloc(w->room * sizeof *w->order), w->sorted = malloc(w->room * sizeof *w->sorted);
    w->uppers = malloc(w->room * sizeof *w->uppers);
    if (!w->order || !w->sorted || !w->uppers) fail("no memory");
  }
  if (n) {
    const Record **at = w->order;
    for (int k = 0; k < run_count; k++) {
      uint32_t left = runs[k].lists[tile].count, block = runs[k].lists[tile].first;
      while (left) {
        const uint32_t some = left < BATCH ? left : BATCH;
        for (uint32_t i = 0; i < some; i++) *at++ = runs[k].records + (size_t)block * BATCH + i;
        left -= some;
        if (left) block = runs[k].next[block];
      }
    }
    if (n <= FEW) uniform = draw_few(w, n, x0, y0, right - 1, h - 1, &colour);
    else draw_many(w, n, x0, y0);
  }
  if (uniform) fill(colour, x0, y0, right, h);
  else pack(w, x0, y0, right, h);
}

/* ---- threads and clock ---- */

static int threads, repeats, next_run, next_tile, arrived, generation;
static double *bins, *tiles;

/* Waits for all threads without sleeping: to wake a thread takes longer than to draw a small picture. */
static void gather(void) {
  const int now = __atomic_load_n(&generation, __ATOMIC_ACQUIRE);
  if (__atomic_add_fetch(&arrived, 1, __ATOMIC_ACQ_REL) == threads) {
    arrived = 0;
    __atomic_store_n(&generation, now + 1, __ATOMIC_RELEASE);
    return;
  }
  for (int spins = 0; __atomic_load_n(&generation, __ATOMIC_ACQUIRE) == now; spins++) {
    if (spins < 10000) _mm_pause();
    else sched_yield();
  }
}

/* The work of a thread; the first also measures the time. */
static void *work(void *clock) {
  Work *w = aligned_alloc(64, (sizeof *w + 63) & ~63ull);
  if (!w) fail("no memory");
  memset(w, 0, sizeof *w);
  for (int k = -1; k < repeats; k++) { /* the first run only faults in the memory */
    double start = 0, binned = 0;
    if (clock) next_run = next_tile = 0, start = milliseconds();
    gather();
    for (int n; (n = __atomic_fetch_add(&next_run, 1, __ATOMIC_RELAXED)) < run_count;) bin(runs + n);
    gather();
    if (clock) binned = milliseconds();
    for (int n; (n = __atomic_fetch_add(&next_tile, 1, __ATOMIC_RELAXED)) < tiles_x * tiles_y;) draw(w, n);
    gather();
    if (clock && k >= 0) bins[k] = binned - start, tiles[k] = milliseconds() - binned;
  }
  return 0;
}

static void keep(const struct scene *scene) {
  const size_t bytes = sizeof(float) * ((size_t)count + CHUNK);
  xs = pages(bytes), ys = pages(bytes), zs = pages(bytes), rs = pages(bytes), colours = pages(bytes);
  for (int k = 0; k < count; k++) {
    const float *s = scene->spheres + 4 * (size_t)k;
    const uint8_t *c = scene->colours + 3 * (size_t)k;
    xs[k] = s[0], ys[k] = s[1], zs[k] = s[2], rs[k] = s[3];
    colours[k] = c[0] | c[1] << 8 | c[2] << 16;
  }
}

int main(int argc, char **argv) {
  if (argc < 6) fail("usage: splat SCENE WIDTH HEIGHT THREADS RUNS [IMAGE]");
  const struct scene scene = read_scene(argv[1]);
  width = atoi(argv[2]), height = atoi(argv[3]), threads = atoi(argv[4]), repeats = atoi(argv[5]);
  if (width < 2 || height < 2 || width > 65535 || height > 65535) fail("splat: a picture of 2 to 65535 columns and rows");
  count = scene.count;
  background = scene.background[0] | scene.background[1] << 8 | scene.background[2] << 16;
  step_x = scene.viewport[0] / scene.viewport[2] / (width - 1), step_y = scene.viewport[1] / scene.viewport[2] / (height - 1);
  middle_x = .5f * (width - 1), middle_y = .5f * (height - 1);
  tiles_x = (width + TILE - 1) / TILE, tiles_y = (height + TILE - 1) / TILE;
  keep(&scene);
#ifdef __AVX512VBMI__
  for (int k = 0; k < 192; k++) places[k] = k / 3 % 64 * 4 + k % 3 - 64 * (k / 64);
#endif
  image = pages((size_t)width * height * 3);
  run_count = threads == 1 ? (count + (1 << 20) - 1) >> 20 : (count + RUN - 1) / RUN;
  if (run_count < 1) run_count = 1;
  runs = calloc(run_count, sizeof *runs);
  for (int k = 0; k < run_count; k++) {
    Run *run = runs + k;
    run->first = (long)count * k / run_count, run->last = (long)count * (k + 1) / run_count;
    run->lists = malloc(sizeof *run->lists * tiles_x * tiles_y);
    if (!run->lists) fail("no memory");
  }
  bins = malloc(sizeof(double) * repeats), tiles = malloc(sizeof(double) * repeats);
  for (int n = 1; n < threads; n++) {
    pthread_t thread;
    if (pthread_create(&thread, 0, work, 0)) fail("no thread");
  }
  work(&threads);
  printf("{\"mode\": \"%d lanes\", ", LANES);
  print_samples("bins", bins, repeats);
  printf(", ");
  print_samples("tiles", tiles, repeats);
  printf("}\n");
  if (argc > 6) write_image(argv[6], image, width, height);
  return 0;
}
