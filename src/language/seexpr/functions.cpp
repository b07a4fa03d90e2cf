#include "language/seexpr/functions.h"

namespace kinora::language::seexpr {

namespace {

constexpr Function kFunctions[] = {
    // mathematics, component by component
    {"abs", "ee", "abs", "", true},
    {"acos", "ee", "acos", "", true},
    {"asin", "ee", "asin", "", true},
    {"atan", "ee", "atan", "", true},
    {"atan2", "eee", "atan2", "", true},
    {"cbrt", "ee", "cbrt", "", true},
    {"ceil", "ee", "ceil", "", true},
    {"cos", "ee", "cos", "", true},
    {"cosh", "ee", "cosh", "", true},
    {"deg", "ee", "degrees", "", true},
    {"exp", "ee", "exp", "", true},
    {"floor", "ee", "floor", "", true},
    {"fmod", "eee", "fmod", "", true},
    {"log", "ee", "log", "", true},
    {"log10", "ee", "log10", "", true},
    {"max", "eee", "max", "", true},
    {"min", "eee", "min", "", true},
    {"clamp", "eeee", "clamp", "", true},
    {"mix", "eeee", "mix", "", true},
    {"pow", "eee", "pow", "", true},
    {"rad", "ee", "radians", "", true},
    {"round", "ee", "round", "", true},
    {"sin", "ee", "sin", "", true},
    {"sinh", "ee", "sinh", "", true},
    {"sqrt", "ee", "sqrt", "", true},
    {"tan", "ee", "tan", "", true},
    {"tanh", "ee", "tanh", "", true},
    {"trunc", "ee", "trunc", "", true},
    {"acosd", "ee", "se_acosd"},
    {"asind", "ee", "se_asind"},
    {"atand", "ee", "se_atand"},
    {"atan2d", "eee", "se_atan2d"},
    {"cosd", "ee", "se_cosd"},
    {"sind", "ee", "se_sind"},
    {"tand", "ee", "se_tand"},
    {"hypot", "eee", "se_hypot"},
    // ranges and steps
    {"boxstep", "eee", "se_boxstep"},
    {"linearstep", "eeee", "se_linearstep"},
    {"smoothstep", "eeee", "se_smoothstep"},
    {"gaussstep", "eeee", "se_gaussstep"},
    {"remap", "eeeeee", "se_remap"},
    {"compress", "eeee", "se_compress"},
    {"expand", "eeee", "se_expand"},
    {"fit", "eeeeee", "se_fit"},
    {"invert", "ee", "se_invert"},
    {"gamma", "eee", "se_gamma"},
    {"bias", "eee", "se_bias"},
    {"contrast", "eee", "se_contrast"},
    {"cycle", "eeee", "se_cycle"},
    // colour
    {"rgbtohsl", "vv", "se_rgbtohsl"},
    {"hsltorgb", "vv", "se_hsltorgb"},
    {"hsi", "vvffff", "se_hsi", "1"},
    {"midhsi", "vvffffff", "se_midhsi", "1|0"},
    {"saturate", "vvf", "se_saturate"},
    // vectors
    {"length", "fv", "length"},
    {"norm", "vv", "se_norm"},
    {"dot", "fvv", "dot"},
    {"cross", "vvv", "cross"},
    {"dist", "fvv", "se_dist"},
    {"angle", "fvv", "se_angle"},
    {"ortho", "vvv", "se_ortho"},
    {"rotate", "vvvf", "se_rotate"},
    // noise
    {"snoise", "fv", "se_snoise"},
    {"vnoise", "vv", "se_vnoise"},
    {"cnoise", "vv", "se_cnoise"},
    {"snoise4", "fvf", "se_snoise4"},
    {"vnoise4", "vvf", "se_vnoise4"},
    {"cnoise4", "vvf", "se_cnoise4"},
    {"pnoise", "fvv", "se_pnoise"},
    {"cellnoise", "fv", "se_cellnoise"},
    {"ccellnoise", "vv", "se_ccellnoise"},
    {"fbm", "fvfff", "se_fbm", "6|2|.5"},
    {"vfbm", "vvfff", "se_vfbm", "6|2|.5"},
    {"cfbm", "vvfff", "se_cfbm", "6|2|.5"},
    {"fbm4", "fvffff", "se_fbm4", "6|2|.5"},
    {"vfbm4", "vvffff", "se_vfbm4", "6|2|.5"},
    {"cfbm4", "vvffff", "se_cfbm4", "6|2|.5"},
    {"turbulence", "fvfff", "se_turbulence", "6|2|.5"},
    {"vturbulence", "vvfff", "se_vturbulence", "6|2|.5"},
    {"cturbulence", "vvfff", "se_cturbulence", "6|2|.5"},
    {"voronoi", "fvffffff", "se_voronoi", "1|.5|0|4|2|.5"},
    {"cvoronoi", "vvffffff", "se_cvoronoi", "1|.5|0|4|2|.5"},
    {"pvoronoi", "vvfffff", "se_pvoronoi", ".5|0|4|2|.5"},
};

// Steps, remap, contrast and the like by the formulas of SeExpr's manual.
constexpr std::string_view kLibrary = R"(
float se_acosd(float x) { return degrees(acos(x)); }
float se_asind(float x) { return degrees(asin(x)); }
float se_atand(float x) { return degrees(atan(x)); }
float se_atan2d(float y, float x) { return degrees(atan2(y, x)); }
float se_cosd(float x) { return cos(radians(x)); }
float se_sind(float x) { return sin(radians(x)); }
float se_tand(float x) { return tan(radians(x)); }
float se_hypot(float x, float y) { return sqrt(x * x + y * y); }

float se_boxstep(float x, float a) { return x < a ? 0.0 : 1.0; }
float se_linearstep(float x, float a, float b) {
  if (a == b) return se_boxstep(x, a);
  return a < b ? clamp((x - a) / (b - a), 0.0, 1.0) : 1.0 - clamp((x - b) / (a - b), 0.0, 1.0);
}
float se_smoothstep(float x, float a, float b) {
  float t = se_linearstep(x, a, b);
  return t * t * (3.0 - 2.0 * t);
}
float se_gaussstep(float x, float a, float b) {
  float t = se_linearstep(x, a, b);
  float left = 1.0 - t;
  return t <= 0.0 ? 0.0 : pow(2.0, -8.0 * left * left);
}
float se_remap(float x, float source, float range, float falloff, float interp) {
  float r = fabs(range);
  float f = fabs(falloff);
  float away = fabs(x - source);
  if (f == 0.0) return away < r ? 1.0 : 0.0;
  int kind = (int)interp;
  if (kind == 1) return se_smoothstep(away, r + f, r);
  if (kind == 2) return se_gaussstep(away, r + f, r);
  return se_linearstep(away, r + f, r);
}
float se_compress(float x, float lo, float hi) { return x * (hi - lo) + lo; }
float se_expand(float x, float lo, float hi) {
  return lo == hi ? (x < lo ? 0.0 : 1.0) : (x - lo) / (hi - lo);
}
float se_fit(float x, float a1, float b1, float a2, float b2) {
  return (x * (b2 - a2) - a1 * b2 + b1 * a2) / (b1 - a1);
}
float se_invert(float x) { return 1.0 - x; }
float se_gamma(float x, float g) { return pow(x, 1.0 / g); }
float se_bias(float x, float b) { return pow(x, log(b) / log(0.5)); }
float se_contrast(float x, float c) {
  return x < 0.5 ? 0.5 * se_bias(2.0 * x, 1.0 - c) : 1.0 - 0.5 * se_bias(2.0 - 2.0 * x, 1.0 - c);
}
float se_cycle(float index, float lo, float hi) {
  float n = floor(hi) - floor(lo) + 1.0;
  return n < 1.0 ? floor(lo) : floor(lo) + mod(floor(index), n);
}

vector se_rgbtohsl(vector c) { return (vector)transformc("rgb", "hsl", (color)c); }
vector se_hsltorgb(vector c) { return (vector)transformc("hsl", "rgb", (color)c); }
vector se_hsi(vector c, float h, float s, float i, float map) {
  vector v = se_rgbtohsl(c);
  float hue = v[0] + h * map / 360.0;
  return se_hsltorgb(vector(hue - floor(hue), v[1] * (1.0 + (s - 1.0) * map), v[2])) * (1.0 + (i - 1.0) * map);
}
vector se_midhsi(vector c, float h, float s, float i, float map, float falloff, float interp) {
  float m = 2.0 * map - 1.0;
  float shape = falloff > 0.0 ? se_remap(fabs(m), 1.0, 0.0, falloff, interp) : fabs(m);
  m = m < 0.0 ? -shape : shape;
  float fs = m < 0.0 ? 1.0 / (1.0 - (s - 1.0) * m) : 1.0 + (s - 1.0) * m;
  float fi = m < 0.0 ? 1.0 / (1.0 - (i - 1.0) * m) : 1.0 + (i - 1.0) * m;
  return se_hsi(c, h * m, fs, fi, 1.0);
}
vector se_saturate(vector c, float amount) {
  float l = 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
  return max(vector(l) * (1.0 - amount) + c * amount, vector(0.0));
}

vector se_norm(vector v) { return normalize(v); }
float se_dist(vector a, vector b) { return length(a - b); }
float se_angle(vector a, vector b) { return acos(clamp(dot(normalize(a), normalize(b)), -1.0, 1.0)); }
vector se_ortho(vector a, vector b) { return normalize(cross(a, b)); }
vector se_rotate(vector p, vector axis, float angle) {
  vector k = normalize(axis);
  return p * cos(angle) + cross(k, p) * sin(angle) + k * (dot(k, p) * (1.0 - cos(angle)));
}

float se_snoise(vector p) { float r = snoise((point)p); return r; }
vector se_vnoise(vector p) { vector r = snoise((point)p); return r; }
vector se_cnoise(vector p) { return 0.5 * se_vnoise(p) + vector(0.5); }
float se_snoise4(vector p, float t) { float r = snoise((point)p, t); return r; }
vector se_vnoise4(vector p, float t) { vector r = snoise((point)p, t); return r; }
vector se_cnoise4(vector p, float t) { return 0.5 * se_vnoise4(p, t) + vector(0.5); }
float se_noise1(float x) { float r = noise(x); return r; }
float se_noise2(float x, float y) { float r = noise(x, y); return r; }
float se_noise3(vector p) { float r = noise((point)p); return r; }
float se_noise4(vector p, float t) { float r = noise((point)p, t); return r; }
float se_pnoise(vector p, vector period) { float r = pnoise((point)p, (point)period); return r; }
float se_cellnoise(vector p) { float r = cellnoise((point)p); return r; }
vector se_ccellnoise(vector p) { vector r = cellnoise((point)p); return r; }
float se_hash(float x, float more) { float r = hashnoise(x, more); return r; }

int se_octaves(float n) { return (int)clamp(n, 1.0, 16.0); }
float se_sum(vector p, float octaves, float lacunarity, float gain, int turbulent) {
  float sum = 0.0;
  float amplitude = 1.0;
  vector q = p;
  int n = se_octaves(octaves);
  for (int i = 0; i < n; ++i) {
    float s = se_snoise(q);
    sum += amplitude * (turbulent ? fabs(s) : s);
    amplitude *= gain;
    q *= lacunarity;
  }
  return sum;
}
vector se_vsum(vector p, float octaves, float lacunarity, float gain, int turbulent) {
  vector sum = 0.0;
  float amplitude = 1.0;
  vector q = p;
  int n = se_octaves(octaves);
  for (int i = 0; i < n; ++i) {
    vector s = se_vnoise(q);
    sum += amplitude * (turbulent ? fabs(s) : s);
    amplitude *= gain;
    q *= lacunarity;
  }
  return sum;
}
float se_fbm(vector p, float o, float l, float g) { return 0.5 * se_sum(p, o, l, g, 0) + 0.5; }
vector se_vfbm(vector p, float o, float l, float g) { return se_vsum(p, o, l, g, 0); }
vector se_cfbm(vector p, float o, float l, float g) { return 0.5 * se_vsum(p, o, l, g, 0) + vector(0.5); }
float se_turbulence(vector p, float o, float l, float g) { return 0.5 * se_sum(p, o, l, g, 1) + 0.5; }
vector se_vturbulence(vector p, float o, float l, float g) { return se_vsum(p, o, l, g, 1); }
vector se_cturbulence(vector p, float o, float l, float g) { return 0.5 * se_vsum(p, o, l, g, 1) + vector(0.5); }
vector se_vfbm4(vector p, float t, float octaves, float lacunarity, float gain) {
  vector sum = 0.0;
  float amplitude = 1.0;
  vector q = p;
  float w = t;
  int n = se_octaves(octaves);
  for (int i = 0; i < n; ++i) {
    sum += amplitude * se_vnoise4(q, w);
    amplitude *= gain;
    q *= lacunarity;
    w *= lacunarity;
  }
  return sum;
}
vector se_cfbm4(vector p, float t, float o, float l, float g) { return 0.5 * se_vfbm4(p, t, o, l, g) + vector(0.5); }
float se_fbm4(vector p, float t, float octaves, float lacunarity, float gain) {
  float sum = 0.0;
  float amplitude = 1.0;
  vector q = p;
  float w = t;
  int n = se_octaves(octaves);
  for (int i = 0; i < n; ++i) {
    sum += amplitude * se_snoise4(q, w);
    amplitude *= gain;
    q *= lacunarity;
    w *= lacunarity;
  }
  return 0.5 * sum + 0.5;
}

void se_cells(vector place, float jitter, float scale, float o, float l, float g, output vector p, output vector first,
              output vector second, output vector cell) {
  p = place;
  if (scale > 0.0) p += scale * se_vfbm(place, o, l, g);
  vector base = floor(p);
  float near1 = 1e30;
  float near2 = 1e30;
  first = p;
  second = p;
  cell = base;
  for (int i = -1; i <= 1; ++i)
    for (int j = -1; j <= 1; ++j)
      for (int k = -1; k <= 1; ++k) {
        vector c = base + vector(i, j, k);
        vector q = c + vector(0.5) + jitter * (se_ccellnoise(c + vector(0.5)) - vector(0.5));
        float d = length(q - p);
        if (d < near1) {
          near2 = near1;
          second = first;
          near1 = d;
          first = q;
          cell = c;
        } else if (d < near2) {
          near2 = d;
          second = q;
        }
      }
}
float se_voronoi(vector place, float type, float jitter, float scale, float o, float l, float g) {
  vector p = 0.0;
  vector first = 0.0;
  vector second = 0.0;
  vector cell = 0.0;
  se_cells(place, jitter, scale, o, l, g, p, first, second, cell);
  float f1 = length(first - p);
  float f2 = length(second - p);
  int kind = (int)type;
  if (kind == 2) return f2;
  if (kind == 3) return f2 - f1;
  if (kind == 4) return se_smoothstep(f2 - f1, 0.0, 0.1 * length(second - first) / max(f1 + f2, 1e-6));
  if (kind == 5) return 0.5 * (f1 + f2);
  return f1;
}
vector se_cvoronoi(vector place, float type, float jitter, float scale, float o, float l, float g) {
  vector p = 0.0;
  vector first = 0.0;
  vector second = 0.0;
  vector cell = 0.0;
  se_cells(place, jitter, scale, o, l, g, p, first, second, cell);
  vector c = se_ccellnoise(cell + vector(0.5, 0.5, 100.5));
  float f1 = length(first - p);
  float f2 = length(second - p);
  int kind = (int)type;
  if (kind == 2) return c * (1.0 - f1);
  if (kind == 3) return c * (f2 - f1);
  return c;
}
vector se_pvoronoi(vector place, float jitter, float scale, float o, float l, float g) {
  vector p = 0.0;
  vector first = 0.0;
  vector second = 0.0;
  vector cell = 0.0;
  se_cells(place, jitter, scale, o, l, g, p, first, second, cell);
  return first;
}

// Which of the weights a number of 0..1 falls into.
int se_weighted(float x, float weights[]) {
  int n = arraylength(weights);
  float total = 0.0;
  for (int i = 0; i < n; ++i) total += max(weights[i], 0.0);
  float rest = clamp(x, 0.0, 1.0) * total;
  int found = n - 1;
  int open = 1;
  for (int i = 0; i < n; ++i) {
    rest -= max(weights[i], 0.0);
    if (open && rest < 0.0) {
      found = i;
      open = 0;
    }
  }
  return found;
}
// Positions count up. Interpolation of what follows a knot: 0 none, 1 linear, 2 smooth, 3 spline, 4 monotone spline.
float se_curve(float x, float pos[], float val[], float interp[]) {
  int n = arraylength(pos);
  if (x <= pos[0]) return val[0];
  if (x >= pos[n - 1]) return val[n - 1];
  int i = 0;
  for (int j = 1; j < n - 1; ++j)
    if (pos[j] <= x) i = j;
  float h = pos[i + 1] - pos[i];
  float t = h > 0.0 ? (x - pos[i]) / h : 0.0;
  float a = val[i];
  float b = val[i + 1];
  int kind = (int)interp[i];
  if (kind == 0) return a;
  if (kind == 1) return mix(a, b, t);
  if (kind == 2) return mix(a, b, t * t * (3.0 - 2.0 * t));
  int before = max(i - 1, 0);
  int after = min(i + 2, n - 1);
  float slope = h > 0.0 ? (b - a) / h : 0.0;
  float w0 = pos[i + 1] - pos[before];
  float w1 = pos[after] - pos[i];
  float m0 = w0 > 0.0 ? (b - val[before]) / w0 : slope;
  float m1 = w1 > 0.0 ? (val[after] - a) / w1 : slope;
  if (kind == 4) {
    // Fritsch and Carlson 1980: level where the curve turns, and nowhere too steep
    m0 = slope == 0.0 || (i > 0 && (a - val[before]) * slope <= 0.0) ? 0.0 : clamp(m0 / slope, 0.0, 3.0) * slope;
    m1 = slope == 0.0 || (after > i + 1 && (val[after] - b) * slope <= 0.0) ? 0.0 : clamp(m1 / slope, 0.0, 3.0) * slope;
  }
  float s = 1.0 - t;
  return a * (1.0 + 2.0 * t) * s * s + m0 * h * t * s * s + b * t * t * (3.0 - 2.0 * t) - m1 * h * t * t * s;
}
)";

}  // namespace

const Function* findFunction(std::string_view name) {
  for (const Function& f : kFunctions)
    if (f.name == name) return &f;
  return nullptr;
}

std::string_view librarySource() { return kLibrary; }

}  // namespace kinora::language::seexpr
