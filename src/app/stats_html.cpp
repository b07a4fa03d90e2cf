#include "app/stats_html.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "app/progress_reporter.h"
#include "image/png_bytes.h"
#include "image/read_write.h"
#include "render/version.h"

namespace kinora::app {

namespace {

using render::PixelMap;
using render::StageTime;
using render::Statistics;

std::string htmlEscaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"')
      out += "&quot;";
    else
      out += c;
  }
  return out;
}

std::string base64(const std::vector<unsigned char>& bytes) {
  static const char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve(bytes.size() / 3 * 4 + 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    const size_t n = std::min<size_t>(3, bytes.size() - i);
    uint32_t v = 0;
    for (size_t k = 0; k < 3; ++k) v = v << 8 | (k < n ? bytes[i + k] : 0u);
    for (size_t k = 0; k < 4; ++k) out += k <= n ? kDigits[v >> (18 - 6 * k) & 63] : '=';
  }
  return out;
}

// A page is to be looked at, not to be as large as the frame: boxes of whole pixels are averaged.
image::Image reduced(const image::Image& source, int most) {
  const int step = std::max(1, (std::max(source.width(), source.height()) + most - 1) / most);
  image::Image out({0, 0, (source.width() + step - 1) / step, (source.height() + step - 1) / step}, source.channels);
  const size_t channels = source.channels.size();
  for (int y = 0; y < out.height(); ++y)
    for (int x = 0; x < out.width(); ++x) {
      std::vector<double> sum(channels, 0);
      int n = 0;
      for (int sy = y * step; sy < std::min((y + 1) * step, source.height()); ++sy)
        for (int sx = x * step; sx < std::min((x + 1) * step, source.width()); ++sx, ++n)
          for (size_t c = 0; c < channels; ++c) {
            const float v = source.pixels[(size_t(sy) * size_t(source.width()) + size_t(sx)) * channels + c];
            sum[c] += std::isfinite(v) ? v : 0;
          }
      for (size_t c = 0; c < channels; ++c)
        out.pixels[(size_t(y) * size_t(out.width()) + size_t(x)) * channels + c] = float(sum[c] / n);
    }
  return out;
}

std::string imageTag(const image::Image& picture, bool encodeSrgb, const std::string& alternative, bool isPixelated) {
  std::vector<unsigned char> bytes;
  if (!image::pngBytes(picture, encodeSrgb, bytes).ok()) return "<p class=note>no picture</p>\n";
  return fmt::format("<img alt=\"{}\" width={} height={}{} src=\"data:image/png;base64,{}\">\n",
                     htmlEscaped(alternative), picture.width(), picture.height(), isPixelated ? " class=map" : "",
                     base64(bytes));
}

// Black, violet, red, orange, pale yellow: brighter is more, on any screen and in grey.
std::array<float, 3> heat(double t) {
  static const float kStops[5][3] = {{0.02f, 0.02f, 0.08f},
                                     {0.33f, 0.06f, 0.43f},
                                     {0.73f, 0.21f, 0.33f},
                                     {0.97f, 0.55f, 0.04f},
                                     {0.99f, 0.99f, 0.75f}};
  const double x = std::clamp(t, 0.0, 1.0) * 4;
  const int i = std::min(3, int(x));
  const float f = float(x - i);
  std::array<float, 3> c;
  for (size_t k = 0; k < 3; ++k) c[k] = kStops[i][k] + f * (kStops[i + 1][k] - kStops[i][k]);
  return c;
}

image::Image heatMap(int width, int height, const std::vector<double>& values, double most) {
  image::Image map({0, 0, width, height}, {{"R"}, {"G"}, {"B"}});
  for (size_t i = 0; i < values.size(); ++i) {
    const auto c = heat(most > 0 ? values[i] / most : 0);
    std::copy(c.begin(), c.end(), &map.pixels[i * 3]);
  }
  return map;
}

// The value that all but one in a thousand stay below: single outliers would leave the rest of a map black.
double nearlyMost(std::vector<double> values) {
  if (values.empty()) return 0;
  const size_t at = std::min(values.size() - 1, values.size() * 999 / 1000);
  std::nth_element(values.begin(), values.begin() + std::ptrdiff_t(at), values.end());
  return values[at];
}

class Page {
 public:
  Page(const Statistics& s, const StatsHeading& h) : s_(s), h_(h) {}

  std::string text() {
    head();
    picture();
    summary();
    time();
    memory();
    rays();
    shaders();
    noise();
    slowness();
    put("</body></html>\n");
    return std::move(out_);
  }

 private:
  template <class... A>
  void put(fmt::format_string<A...> form, A&&... arguments) {
    fmt::format_to(std::back_inserter(out_), form, std::forward<A>(arguments)...);
  }
  void raw(const std::string& text) { out_ += text; }
  void row(const std::string& name, const std::string& value, double share = -1) {
    put("<tr><td>{}</td><td class=n>{}</td>", htmlEscaped(name), htmlEscaped(value));
    if (share >= 0)
      put("<td class=b><div style=\"width:{:.2f}%\"></div></td><td class=n>{:.1f} %</td>", 100 * std::min(share, 1.0),
          100 * share);
    put("</tr>\n");
  }

  void head() {
    raw("<!DOCTYPE html>\n<html lang=en><head><meta charset=utf-8><meta name=viewport "
        "content=\"width=device-width\">\n");
    put("<title>{}, frame {}</title>\n", htmlEscaped(h_.scene), h_.frame);
    raw("<style>body{font:15px/1.45 sans-serif;margin:2em auto;max-width:64em;padding:0 "
        "1em;color:#222;background:#fff}"
        "h1{font-size:1.5em;margin-bottom:0}h2{font-size:1.15em;margin:1.8em 0 .4em;border-bottom:1px solid #ccc}"
        "table{border-collapse:collapse}td{padding:.12em .8em .12em 0;vertical-align:middle}.n{text-align:right;"
        "font-variant-numeric:tabular-nums;white-space:nowrap}.b{width:22em}.b "
        "div{background:#4a7ab5;height:.9em;min-width:1px}"
        "img{max-width:100%;height:auto;background:#000}.map{image-rendering:pixelated;width:100%;max-width:40em}"
        ".note{color:#666}code{background:#f2f2f2;padding:0 .25em}</style></head><body>\n");
    put("<h1>{}</h1>\n<p class=note>frame {} &middot; {} &middot; Kinora {}</p>\n", htmlEscaped(h_.scene), h_.frame,
        htmlEscaped(h_.outcome), kVersion);
  }

  void picture() {
    image::Image p;
    if (h_.picture.empty() || !image::read(h_.picture, p).ok()) {
      raw("<p class=note>No picture was written.</p>\n");
      return;
    }
    const bool isLinear =
        p.channels[0].type == image::StoredType::Half || p.channels[0].type == image::StoredType::Float;
    raw(imageTag(reduced(p, 1280), isLinear, "the picture", false));
    put("<p class=note>{}, {} x {} pixels</p>\n", htmlEscaped(h_.picture), p.width(), p.height());
  }

  void summary() {
    raw("<h2>Scene and time</h2><table>\n");
    row("load and build", fmt::format("{:.2f} s", s_.loadSeconds));
    row("of it, building", fmt::format("{:.2f} s", s_.buildSeconds));
    row("render", fmt::format("{:.2f} s", s_.renderSeconds));
    row("samples", fmt::format("{}", s_.samples));
    row("primitives, placements, triangles", fmt::format("{}, {}, {}", s_.primitives, s_.instances, s_.triangles));
    row("lights, materials, programs", fmt::format("{}, {}, {}", s_.lights, s_.materials, s_.programs));
    row("samples not finite, saturated, negative",
        fmt::format("{}, {}, {}", s_.nonFiniteSamples, s_.saturatedSamples, s_.negativeSamples));
    raw("</table>\n");
  }

  void time() {
    uint64_t sum = 0;
    for (const uint64_t t : s_.stageNanoseconds) sum += t;
    raw("<h2>Time by stage, all threads together</h2><table>\n");
    for (size_t i = 0; i < size_t(StageTime::Count); ++i) {
      const double t = double(s_.stageNanoseconds[i]);
      row(render::nameOf(StageTime(i)), fmt::format("{:.3f} s", t * 1e-9), sum ? t / double(sum) : 0);
    }
    row("sum", fmt::format("{:.3f} s", double(sum) * 1e-9));
    raw("</table>\n");
  }

  void memory() {
    std::vector<Statistics::Owner> owners = s_.memory;
    std::stable_sort(owners.begin(), owners.end(), [](const auto& a, const auto& b) { return a.bytes > b.bytes; });
    const double most =
        double(std::max<uint64_t>(1, std::max(h_.residentPeakBytes, owners.empty() ? 0 : owners[0].bytes)));
    raw("<h2>Memory by owner</h2><table>\n");
    for (const auto& o : owners) row(o.name, asBytes(o.bytes), double(o.bytes) / most);
    if (h_.residentPeakBytes)
      row("process, at its peak", asBytes(h_.residentPeakBytes), double(h_.residentPeakBytes) / most);
    raw("</table>\n");
    put("<p class=note>Textures: {} lookups, {} misses, {} held, {} read, {} tiles of it again.</p>\n",
        s_.textureLookups, s_.textureMisses, asBytes(s_.textureBytes), asBytes(s_.textureBytesRead),
        s_.textureTilesAgain);
    if (const auto& v = s_.volumes; v.memoryBytes + v.fileBytes)
      put("<p class=note>Grids of volumes: {} in memory, {} in a file, {} in memory at most, {} pieces let go.</p>\n",
          asBytes(v.memoryBytes), asBytes(v.fileBytes), asBytes(v.mostBytes), v.letGo);
  }

  void rays() {
    const uint64_t all = s_.cameraRays + s_.indirectRays + s_.shadowRays + s_.lightRays;
    const auto share = [](double a, double b) { return b > 0 ? a / b : 0; };
    raw("<h2>Rays</h2><table>\n");
    for (const auto& [name, n] : {std::pair{"camera", s_.cameraRays}, std::pair{"indirect", s_.indirectRays},
                                  std::pair{"shadow", s_.shadowRays}, std::pair{"light", s_.lightRays}})
      row(name, fmt::format("{}", n), share(double(n), double(all)));
    row("all", fmt::format("{}, {:.3g} a second", all, share(double(all), s_.renderSeconds)));
    raw("</table>\n<h2>Lane use: active of possible SIMD lanes</h2><table>\n");
    const auto laneRow = [&](const std::string& name, const render::LaneUse& l) {
      if (l.possible)
        row(name,
            fmt::format("{} of {}, {:.1f} points a group", l.active, l.possible,
                        share(double(l.active), double(l.groups))),
            share(double(l.active), double(l.possible)));
    };
    for (size_t k = 0; k < s_.lanesAt.size(); ++k)
      laneRow(k == 0                      ? "camera hits"
              : k + 1 < s_.lanesAt.size() ? fmt::format("hits after {} bounces", k)
                                          : fmt::format("hits after {} bounces and more", k),
              s_.lanesAt[k]);
    laneRow("presence and clear shadows", s_.lanesQueries);
    if (s_.lanesWalks.possible) laneRow("manifold walks", s_.lanesWalks);
    raw("</table>\n");
    put("<p class=note>{} shading groups of {:.1f} points on average, {} ray groups.</p>\n", s_.shadingGroups,
        share(double(s_.shadingPoints), double(s_.shadingGroups)), s_.groups);
  }

  void shaders() {
    if (s_.shaders.empty()) return;
    raw("<h2>Shaders: time, with points, instructions a run and lanes in use</h2><table>\n");
    const render::ShaderCost all = costOfShaders(s_);
    std::vector<render::ShaderCost> rows = slowestShaders(s_, 10);
    rows.push_back(all);
    for (const render::ShaderCost& c : rows)
      row(c.name,
          fmt::format("{:.3f} s; {} points of {} materials, {:.1f} ns each; {:.0f} instructions; {:.0f} % of lanes",
                      double(c.nanoseconds) * 1e-9, c.points, c.materials,
                      c.points ? double(c.nanoseconds) / double(c.points) : 0,
                      c.countedRuns ? double(c.instructions + c.uniformInstructions) / double(c.countedRuns) : 0,
                      c.lanes.possible ? 100 * double(c.lanes.active) / double(c.lanes.possible) : 0),
          all.nanoseconds ? double(c.nanoseconds) / double(all.nanoseconds) : 0);
    raw("</table>\n");
    put("<p class=note>{} files compiled to {} programs in {:.4f} s. Instructions and lanes are those of every 16th "
        "run.</p>\n",
        s_.shadersCompiled, s_.shaderPrograms, s_.shaderCompileSeconds);
  }

  void noise() {
    const PixelMap& m = s_.relativeError;
    raw("<h2>Worst pixels</h2>\n");
    if (m.values.empty()) {
      raw("<p class=note>Not measured: at least two samples a pixel and a colour are needed.</p>\n");
      return;
    }
    const std::vector<double> values(m.values.begin(), m.values.end());
    const double most = nearlyMost(values);
    image::Image whole({0, 0, m.width, m.height}, {{"error"}});
    whole.pixels.assign(m.values.begin(), m.values.end());
    const image::Image small = reduced(whole, 640);
    raw(imageTag(heatMap(small.width(), small.height(), {small.pixels.begin(), small.pixels.end()}, most), false,
                 "heat map of the relative error", true));
    put("<p class=note>Relative error of the first colour, from the difference of its two halves of samples; the "
        "brightest colour is {:.3g}.</p>\n<table><tr><td>pixel</td><td class=n>relative error</td></tr>\n",
        most);
    for (const WorstPixel& p : worstPixels(s_, 10))
      row(fmt::format("{}, {}", p.x, p.y), fmt::format("{:.3g}", p.error));
    raw("</table>\n<p class=note><code>--only-sample X,Y,S</code> prints what a sample's path met.</p>\n");
  }

  void slowness() {
    if (s_.buckets.empty()) return;
    int x0 = s_.buckets[0].x, y0 = s_.buckets[0].y, x1 = x0, y1 = y0;
    const int size = std::max(1, s_.buckets[0].size);
    for (const auto& b : s_.buckets) {
      x0 = std::min(x0, b.x), y0 = std::min(y0, b.y);
      x1 = std::max(x1, b.x), y1 = std::max(y1, b.y);
    }
    const int width = (x1 - x0) / size + 1, height = (y1 - y0) / size + 1;
    std::vector<double> values(size_t(width) * size_t(height), 0);
    for (const auto& b : s_.buckets)
      values[size_t((b.y - y0) / size) * size_t(width) + size_t((b.x - x0) / size)] = double(b.nanoseconds) * 1e-6;
    const double most = *std::max_element(values.begin(), values.end());
    put("<h2>Slowest buckets</h2>\n");
    raw(imageTag(heatMap(width, height, values, most), false, "heat map of time", true));
    put("<p class=note>Time of each bucket of {0} x {0} pixels; the brightest colour is {1:.3g} ms.</p>\n<table>\n",
        size, most);
    for (const render::BucketTime& b : slowestBuckets(s_, 5))
      row(fmt::format("{}, {}", b.x, b.y), fmt::format("{:.3g} ms", double(b.nanoseconds) * 1e-6));
    raw("</table>\n");
  }

  const Statistics& s_;
  const StatsHeading& h_;
  std::string out_;
};

}  // namespace

std::string statsAsHtml(const Statistics& statistics, const StatsHeading& heading) {
  return Page(statistics, heading).text();
}

}  // namespace kinora::app
