// Whole frames whose materials are networks of ten shaders against the same frames with the plug-ins that do the
// same: what the shading language costs where it is used.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <stdexcept>

#include "film/film.h"
#include "plugin/registry.h"
#include "render/renderer.h"
#include "rib/reader.h"
#include "scenes.h"
#include "shading.h"

namespace kinora::bench {

namespace {

// The plug-ins' arithmetic, node for node (plugins/pattern/*), as far as the networks below use it. Only the noise is
// another: the language's own gradient noise.
struct ShaderText {
  const char *name, *text;
};
constexpr ShaderText kNodes[] = {
    {"fractal", R"(shader fractal(int layers = 6, float frequency = 1, float lacunarity = 2, float dimension = 1,
    int turbulent = 0, color colorScale = 1, color colorOffset = 0, float floatScale = 1, float floatOffset = 0,
    output float resultF = 0, output color resultRGB = 0) {
  point p = P * frequency;
  float radius = 0.5 * length(filterwidth(P)) * frequency;
  float gain = pow(lacunarity, -dimension), mean = turbulent ? 0.1995 : 0;
  float sum = 0, amplitude = 1, f = 1, total = 0;
  for (int i = 0; i < layers; i++) {
    float x = clamp(1.6 - radius * f * 2.4, 0, 1), visible = x * x * (3 - 2 * x), n = mean;
    if (visible > 0) {
      n = noise("perlin", p * f + vector(i * 17.317, i * 31.719, i * 23.541));
      if (turbulent) n = abs(n);
      n = mix(mean, n, visible);
    }
    sum += n * amplitude;
    total += amplitude;
    amplitude *= gain;
    f *= lacunarity;
  }
  float raw = clamp(sum / total, turbulent ? 0.0 : -1.0, 1.0);
  if (!turbulent) raw = raw * 0.5 + 0.5;
  resultF = raw * floatScale + floatOffset;
  resultRGB = raw * colorScale + colorOffset;
})"},
    {"remap", R"(float biased(float x, float b) {
  return b == 0.5 ? x : sign(x) * pow(abs(x), -log2(clamp(b, 1e-4, 0.9999)));
}
float one(float v, float inputMin, float inputMax, int clampInput, float bias, float gain, float outputMin, float outputMax,
          int clampOutput) {
  float span = inputMax - inputMin, x = span != 0 ? (v - inputMin) / span : (v >= inputMin ? 1.0 : 0.0);
  if (clampInput) x = clamp(x, 0, 1);
  x = biased(x, bias);
  if (gain != 0.5) x = x < 0.5 ? biased(x + x, 1 - gain) * 0.5 : 1 - biased(2 - x - x, 1 - gain) * 0.5;
  x = mix(outputMin, outputMax, x);
  return clampOutput ? clamp(x, min(outputMin, outputMax), max(outputMin, outputMax)) : x;
}
shader remap(color inputRGB = 0, float inputMin = 0, float inputMax = 1, int clampInput = 1, float bias = 0.5, float gain = 0.5,
    float outputMin = 0, float outputMax = 1, int clampOutput = 1, output color resultRGB = 0, output float resultR = 0) {
  resultRGB = color(one(inputRGB[0], inputMin, inputMax, clampInput, bias, gain, outputMin, outputMax, clampOutput),
                    one(inputRGB[1], inputMin, inputMax, clampInput, bias, gain, outputMin, outputMax, clampOutput),
                    one(inputRGB[2], inputMin, inputMax, clampInput, bias, gain, outputMin, outputMax, clampOutput));
  resultR = resultRGB[0];
})"},
    {"mixed", R"(shader mixed(color color1 = 0, color color2 = 1, float mix = 0, output color resultRGB = 0) {
  resultRGB = color1 + mix * (color2 - color1);
})"},
    {"gamma", R"(shader gamma(color inputRGB = 0, float gamma = 1, output color resultRGB = 0) {
  resultRGB = sign(inputRGB) * pow(abs(inputRGB), 1 / max(gamma, 1e-3));
})"},
    {"exposure", R"(shader exposure(color inputRGB = 0, float stops = 0, output color resultRGB = 0) {
  resultRGB = inputRGB * exp2(stops);
})"},
    {"multiply",
     R"(shader multiply(color topRGB = 0, float topA = 1, color bottomRGB = 0, float bottomA = 1, int clampOutput = 1,
    output color resultRGB = 0) {
  color c = topA * bottomA * topRGB * bottomRGB + topA * (1 - bottomA) * topRGB + bottomA * (1 - topA) * bottomRGB;
  float a = topA + bottomA * (1 - topA);
  resultRGB = a > 0 ? c / a : color(0);
  if (clampOutput) resultRGB = clamp(resultRGB, color(0), color(1));
})"},
    {"threshold",
     R"(shader threshold(color inputRGB = 0, float threshold = 0.5, float transitionWidth = 0, output float resultF = 0) {
  float t = clamp((inputRGB[0] - threshold) / max(abs(transitionWidth), 1e-6) + 0.5, 0, 1);
  resultF = t * t * (3 - 2 * t);
})"},
    {"limit",
     R"(shader limit(color inputRGB = 0, color min = 0, color max = 1, output color resultRGB = 0, output float resultR = 0) {
  resultRGB = clamp(inputRGB, min, max);
  resultR = resultRGB[0];
})"}};

// Ten nodes; %d: numbers in which the materials differ.
constexpr const char* kByShaders = R"(
Pattern "fractal" "n1" "int layers" [5] "float frequency" [%g] "color colorScale" [.9 .7 .5] "color colorOffset" [.1 .1 .1]
Pattern "fractal" "n2" "int layers" [3] "float frequency" [%g] "int turbulent" [1] "color colorScale" [2 2 2]
Pattern "remap" "n3" "reference color inputRGB" ["n1:resultRGB"] "float inputMin" [.2] "float inputMax" [.8] "float gain" [.7]
Pattern "mixed" "n4" "color color1" [.7 .35 .12] "color color2" [.15 .3 .5] "reference float mix" ["n3:resultR"]
Pattern "gamma" "n5" "reference color inputRGB" ["n4:resultRGB"] "float gamma" [1.4]
Pattern "exposure" "n6" "reference color inputRGB" ["n5:resultRGB"] "float stops" [%g]
Pattern "multiply" "n7" "reference color topRGB" ["n6:resultRGB"] "reference color bottomRGB" ["n1:resultRGB"] "float topA" [.6]
Pattern "threshold" "n8" "reference color inputRGB" ["n2:resultRGB"] "float threshold" [.35] "float transitionWidth" [.2]
Pattern "mixed" "n9" "reference color color1" ["n7:resultRGB"] "color color2" [.8 .75 .6] "reference float mix" ["n8:resultF"]
Pattern "limit" "n10" "reference color inputRGB" ["n9:resultRGB"] "color min" [.02 .02 .02] "color max" [.9 .9 .9]
)";
constexpr const char* kByPlugins = R"(
Pattern "PxrFractal" "n1" "int surfacePosition" [1] "int layers" [5] "float frequency" [%g] "color colorScale" [.9 .7 .5] "color colorOffset" [.1 .1 .1]
Pattern "PxrFractal" "n2" "int surfacePosition" [1] "int layers" [3] "float frequency" [%g] "int turbulent" [1] "color colorScale" [2 2 2]
Pattern "PxrRemap" "n3" "reference color inputRGB" ["n1:resultRGB"] "float inputMin" [.2] "float inputMax" [.8] "float gain" [.7]
Pattern "PxrMix" "n4" "color color1" [.7 .35 .12] "color color2" [.15 .3 .5] "reference float mix" ["n3:resultR"]
Pattern "PxrGamma" "n5" "reference color inputRGB" ["n4:resultRGB"] "float gamma" [1.4]
Pattern "PxrExposure" "n6" "reference color inputRGB" ["n5:resultRGB"] "float stops" [%g]
Pattern "PxrBlend" "n7" "int operation" [18] "reference color topRGB" ["n6:resultRGB"] "reference color bottomRGB" ["n1:resultRGB"] "float topA" [.6]
Pattern "PxrThreshold" "n8" "reference color inputRGB" ["n2:resultRGB"] "int channel" [0] "float threshold" [.35] "float transitionWidth" [.2]
Pattern "PxrMix" "n9" "reference color color1" ["n7:resultRGB"] "color color2" [.8 .75 .6] "reference float mix" ["n8:resultF"]
Pattern "PxrClamp" "n10" "reference color inputRGB" ["n9:resultRGB"] "color min" [.02 .02 .02] "color max" [.9 .9 .9]
)";
constexpr const char* kBxdf = R"(
Bxdf "PxrSurface" "m" "reference color diffuseColor" ["n10:resultRGB"] "reference float specularRoughness" ["n10:resultR"]
  "color specularFaceColor" [.05 .05 .05] "color specularEdgeColor" [1 1 1] "int diffuseDoubleSided" [1] "int specularDoubleSided" [1]
)";

// A room of 24 bumpy squares around the camera, each with numbers of its own.
std::string frameText(const char* network, bool quick) {
  std::string text = R"(Format 160 90 1
Hider "raytrace" "int maxsamples" [8]
Projection "perspective" "fov" [75]
Integrator "PxrPathTracer" "integrator" "int maxIndirectBounces" [4]
WorldBegin
AttributeBegin
Rotate 90 1 0 0
Translate 0 0 -.7
Light "PxrRectLight" "light" "float intensity" [6]
AttributeEnd
)";
  if (quick) text.replace(text.find("160 90"), 6, "32 18 ");
  for (int face = 0; face < 6; ++face)
    for (int part = 0; part < 4; ++part) {
      char nodes[4096];
      const int k = face * 4 + part;
      std::snprintf(nodes, sizeof nodes, network, 1.5 + 0.1 * k, 3 + 0.13 * k, -0.2 + 0.02 * k);
      text += "AttributeBegin\n" + std::string(nodes) + kBxdf;
      static const char* const kTurns[] = {
          "", "Rotate 90 0 1 0", "Rotate 180 0 1 0", "Rotate 270 0 1 0", "Rotate 90 1 0 0", "Rotate -90 1 0 0"};
      const double x = part % 2 ? 0 : -1, y = part / 2 ? 0 : -1;
      char square[256];
      std::snprintf(square, sizeof square,
                    "\nPolygon \"P\" [%g %g 1  %g %g 1  %g %g 1  %g %g 1] \"st\" [0 0 0 1 1 1 1 0]\n", x, y, x, y + 1,
                    x + 1, y + 1, x + 1, y);
      text += std::string(kTurns[face]) + square + "AttributeEnd\n";
    }
  return text + "WorldEnd\n";
}

double meanOf(const film::Film& film) {
  double sum = 0;
  const film::Window& w = film.window();
  for (int y = w.y0; y < w.y1; ++y)
    for (int x = w.x0; x < w.x1; ++x) {
      float c[4] = {};
      film.resolvePixel(0, x, y, c);
      sum += (c[0] + c[1] + c[2]) / 3;
    }
  return sum / double(w.pixels());
}

}  // namespace

void measureShadedFrames(const Options& options, Figures& figures) {
  std::string folder = (std::filesystem::temp_directory_path() / "kinora-bench-XXXXXX").string();
  if (!mkdtemp(folder.data())) throw std::runtime_error("no folder for temporary files");
  for (const ShaderText& s : kNodes) std::ofstream(folder + "/" + s.name + ".osl") << s.text;
  Registry registry;
  Diagnostics diagnostics([](const std::string& line, Severity s) {
    if (s != Severity::Info) std::fprintf(stderr, "%s\n", line.c_str());
  });
  std::unique_ptr<render::Renderer> renderers[2];  // shaders, plug-ins
  bool isReady = true;
  for (int k = 0; k < 2 && isReady; ++k) {
    std::optional<scene::Scene> scene;
    rib::RibReader reader(diagnostics, {}, [&](scene::Scene&& s) { scene = std::move(s); });
    reader.readString("bench.rib", frameText(k ? kByPlugins : kByShaders, options.quick));
    reader.finish();
    render::Settings settings;
    settings.threads = 1;
    settings.samplesPerPixel = options.quick ? 1 : 4;
    settings.shaderPath = {folder};
    renderers[k] = std::make_unique<render::Renderer>(registry, diagnostics, settings);
    isReady =
        scene && renderers[k]->load(std::move(*scene)) && renderers[k]->renderFilm() == render::Outcome::Complete;
  }
  std::error_code ignored;
  std::filesystem::remove_all(folder, ignored);
  if (!isReady || diagnostics.errors() + diagnostics.warnings()) {
    std::fprintf(stderr, "kinora-bench: the frames of shaders cannot be rendered as they are meant\n");
    return;
  }
  // only the noise differs
  const double light[2] = {meanOf(renderers[0]->film()), meanOf(renderers[1]->film())};
  std::printf("    mean of the frames: %.4f by shaders, %.4f by plug-ins\n", light[0], light[1]);
  std::vector<double> ratios, seconds[2];
  for (int r = 0; r < options.repeat; ++r) {
    std::vector<double> pairs;
    for (int p = 0; p < (options.quick ? 1 : 5); ++p) {
      double s[2];
      for (int k = 0; k < 2; ++k) {
        const int which = (p + k) % 2;
        const double start = threadSeconds();
        renderers[which]->renderFilm();
        s[which] = threadSeconds() - start;
      }
      pairs.push_back(s[0] / s[1]);
      for (int k = 0; k < 2; ++k) seconds[k].push_back(s[k]);
    }
    ratios.push_back(median(pairs));
  }
  figures.add(
      "frame_vs_patterns", ratios,
      "CPU time of a frame whose materials are networks of ten shaders over that with the plug-ins that do the same");
  double stage[2];
  for (int k = 0; k < 2; ++k)
    stage[k] = double(renderers[k]->statistics().stageNanoseconds[size_t(render::StageTime::Closures)]) * 1e-9;
  figures.add("frame_vs_patterns_networks", {stage[0] / stage[1]},
              "the same of the stage that runs networks and makes closures, all frames together");
  figures.add("frame_vs_patterns_seconds_networks", {stage[0]}, "that stage by shaders, of all frames");
  figures.add("frame_vs_patterns_seconds_shaders", seconds[0], "CPU time of the frame by shaders");
  figures.add("frame_vs_patterns_seconds_patterns", seconds[1], "CPU time of the frame by plug-ins");
}

}  // namespace kinora::bench
