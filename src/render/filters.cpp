#include "render/filters.h"

#include <kinora/pixel_filter.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <set>
#include <tuple>
#include <utility>

#include "base/text.h"
#include "plugin/refused.h"
#include "render/light_places.h"
#include "texture/texture_system.h"

namespace kinora::render {

namespace {

constexpr int kRows = 16;  // of pixels that are filtered at a time

bool isCombiner(const scene::Node& n) { return lowerCase(n.plugin).ends_with("filtercombiner"); }

// The nodes that run, in order.
std::vector<scene::NodePtr> active(const std::vector<scene::NodePtr>& nodes, Diagnostics& diagnostics) {
  if (nodes.empty()) return {};
  const scene::NodePtr last = nodes.back();
  if (!isCombiner(*last)) return {last};
  std::vector<scene::NodePtr> order;
  const scene::Parameter* filter = last->params.find("filter");
  for (const std::string& handle : filter ? filter->strings : std::vector<std::string>()) {
    const auto it = std::find_if(nodes.begin(), nodes.end(), [&](const auto& n) { return n->handle == handle; });
    if (it == nodes.end() || isCombiner(**it))
      diagnostics.warning(
          "FILTER-REFERENCE", last->pos,
          last->plugin + " '" + last->handle + "' names the filter '" + handle + "', which is not there",
          "it is left out");
    else
      order.push_back(*it);
  }
  return order;
}

}  // namespace

void FilterChain::make(Kind kind, const std::vector<scene::NodePtr>& nodes, const film::ChannelLayout& layout,
                       const ChannelFilterInfo& picture, Registry& registry, const Host& host, uint32_t width,
                       Diagnostics& diagnostics) {
  kind_ = kind;
  steps_.clear();
  for (const scene::NodePtr& n : active(nodes, diagnostics)) {
    const Descriptor* d = registry.find(kind, n->plugin, diagnostics, n->pos);
    const std::string who = std::string(nameOf(kind)) + " '" + n->plugin + "' (node '" + n->handle + "')";
    if (!d) {
      diagnostics.warning("PLUGIN-MISSING", n->pos, "no " + who, "it is left out", adviceOnMissing(kind, n->plugin));
      continue;
    }
    Step step;
    const auto* traits = static_cast<const ChannelFilterTraits*>(d->traits);
    step.functions = functionsFor(*d, width);
    if (!traits || !traits->channel || !step.functions ||
        !step.instance.create(*d, n.get(), nullptr, &picture, host, diagnostics))
      continue;
    step.seesPicture = kind == Kind::DisplayFilter && traits->seesPicture;
    for (uint32_t i = 0; i < kMostChannels; ++i) {
      const char* name = traits->channel(step.instance.data(), i);
      if (!name) break;
      Channel c;
      c.name = name;
      c.layoutIndex = layout.find(name);
      std::array<float, 3> remap;
      for (int k = 0; k < layout.size() && c.layoutIndex < 0; ++k)
        if (film::sourceBehind(layout[k].source, remap) == name) c.layoutIndex = k;
      if (c.layoutIndex >= 0) {
        c.width = layout[c.layoutIndex].width;
        c.record = layout.recordOffset(c.layoutIndex);
        if (c.width != 1 && c.width != 3) c.layoutIndex = -1;
      }
      if (c.layoutIndex < 0)
        diagnostics.warning("FILTER-CHANNEL", n->pos,
                            who + " asks for the channel '" + c.name + "', which the frame has not",
                            "the filter does without it",
                            "a Display must hold it; \"+NAME\" \"null\" keeps a channel without writing it");
      step.channels.push_back(std::move(c));
    }
    steps_.push_back(std::move(step));
  }
}

bool FilterChain::uses(const std::string& name) const {
  for (const Step& step : steps_)
    for (const Channel& c : step.channels)
      if (c.name == name) return true;
  return false;
}

void FilterChain::call(const Step& step, const ChannelFilterArgs& args) const {
  if (kind_ == Kind::SampleFilter)
    static_cast<const SampleFilterFunctions*>(step.functions)->filter(step.instance.data(), &args);
  else
    static_cast<const DisplayFilterFunctions*>(step.functions)->filter(step.instance.data(), &args);
}

void FilterChain::run(uint32_t count, const int32_t* x, const int32_t* y, float* const* records) const {
  FilterChannel list[kMostChannels];
  for (const Step& step : steps_) {
    uint32_t n = 0;
    for (const Channel& c : step.channels) {
      FilterChannel f{c.name.c_str(), 0, {}, {}};
      if (c.layoutIndex >= 0) {
        f.components = uint32_t(c.width);
        for (int k = 0; k < c.width; ++k) f.data[k] = records[c.record + k];
      }
      list[n++] = f;
    }
    call(step, {count, x, y, list, n, {}});
  }
}

film::FilteredPixels FilterChain::run(const film::Film& film) const {
  film::FilteredPixels out;
  out.window = film.window();
  const int w = out.window.width();
  for (const Step& step : steps_)
    for (const Channel& c : step.channels) {
      if (c.layoutIndex < 0 || out.channels.contains(c.layoutIndex)) continue;
      auto& channel = out.channels[c.layoutIndex];
      channel.width = c.width;
      channel.values.resize(size_t(out.window.pixels()) * size_t(c.width));
      float* to = channel.values.data();
      for (int y = out.window.y0; y < out.window.y1; ++y)
        for (int x = out.window.x0; x < out.window.x1; ++x, to += c.width) film.resolvePixel(c.layoutIndex, x, y, to);
    }
  const uint32_t most = padded(uint32_t(w) * kRows);
  std::vector<int32_t> xs(most), ys(most);
  std::vector<std::vector<float>> planes, before;
  for (const Step& step : steps_) {
    before.assign(step.seesPicture ? step.channels.size() * 3 : 0, {});
    for (size_t c = 0; c < step.channels.size() && step.seesPicture; ++c) {
      if (step.channels[c].layoutIndex < 0) continue;
      const film::FilteredPixels::Channel& whole = out.channels[step.channels[c].layoutIndex];
      for (size_t q = 0; q < size_t(whole.width); ++q) {
        std::vector<float>& plane = before[3 * c + q];
        plane.resize(size_t(out.window.pixels()));
        for (size_t i = 0; i < plane.size(); ++i) plane[i] = whole.values[i * size_t(whole.width) + q];
      }
    }
    planes.assign(step.channels.size() * 3, std::vector<float>(most, 0.f));
    for (int y0 = out.window.y0; y0 < out.window.y1; y0 += kRows) {
      const uint32_t n = uint32_t(w) * uint32_t(std::min(kRows, out.window.y1 - y0));
      const size_t first = size_t(y0 - out.window.y0) * size_t(w);
      for (uint32_t i = 0; i < padded(n); ++i) {
        const uint32_t j = std::min(i, n - 1);
        xs[i] = out.window.x0 + int32_t(j % uint32_t(w));
        ys[i] = y0 + int32_t(j / uint32_t(w));
      }
      FilterChannel list[kMostChannels];
      uint32_t k = 0;
      for (const Channel& c : step.channels) {
        FilterChannel f{c.name.c_str(), 0, {}, {}};
        if (c.layoutIndex >= 0) {
          f.components = uint32_t(c.width);
          const float* from = out.channels[c.layoutIndex].values.data() + first * size_t(c.width);
          for (int q = 0; q < c.width; ++q) {
            f.data[q] = planes[3 * k + size_t(q)].data();
            for (uint32_t i = 0; i < padded(n); ++i)
              f.data[q][i] = from[size_t(std::min(i, n - 1)) * size_t(c.width) + size_t(q)];
            if (step.seesPicture) f.before[q] = before[3 * k + size_t(q)].data();
          }
        }
        list[k++] = f;
      }
      call(step, {n, xs.data(), ys.data(), list, k, {out.window.x0, out.window.y0, out.window.x1, out.window.y1}});
      for (uint32_t c = 0; c < k; ++c) {
        if (!list[c].components) continue;
        const int width = step.channels[c].width;
        float* to = out.channels[step.channels[c].layoutIndex].values.data() + first * size_t(width);
        for (int q = 0; q < width; ++q)
          for (uint32_t i = 0; i < n; ++i) to[size_t(i) * size_t(width) + size_t(q)] = list[c].data[q][i];
      }
    }
  }
  return out;
}

film::DisplayOutput::PixelStage displayFiltersOf(const film::DisplayPlan& plan, const film::Film& film,
                                                 Registry& registry, Diagnostics& diagnostics) {
  struct Kept {
    Settings settings;
    WorldBuilder builder;  // the host that plug-ins are made by
    FilterChain chain;
    Kept(Registry& r, Diagnostics& d) : builder(r, d, settings) {}
  };
  auto kept = std::make_shared<Kept>(registry, diagnostics);
  kept->builder.textures().setSearchPath(plan.texturePath);
  kept->chain.make(Kind::DisplayFilter, plan.displayFilters, plan.layout,
                   {{uint32_t(film.width()), uint32_t(film.height())}, plan.pixelAspect}, registry,
                   kept->builder.host(), kept->builder.width(), diagnostics);
  if (kept->chain.empty()) return {};
  return [kept](const film::Film& f) { return kept->chain.run(f); };
}

void makePixelFilter(const scene::Scene& scene, Registry& registry, const Host& host, Diagnostics& diagnostics,
                     film::PixelFilter& out) {
  const auto& names = film::PixelFilter::names();
  const float x = scene.pixelFilterWidth[0], y = scene.pixelFilterWidth[1];
  film::Status status;
  const Descriptor* d = nullptr;
  if (std::find(names.begin(), names.end(), lowerCase(scene.pixelFilter)) == names.end())
    d = registry.find(Kind::PixelFilter, scene.pixelFilter, diagnostics, scene.pos);
  // widths that are no widths are refused before the plug-in sees them
  if (d && x > 0 && y > 0 && d->create && functionsFor(*d, 1)) {
    const PixelFilterInfo info{{x, y}};
    auto instance = std::make_shared<Instance>();
    const auto* functions = static_cast<const PixelFilterFunctions*>(functionsFor(*d, 1));
    if (instance->create(*d, nullptr, nullptr, &info, host, diagnostics)) {
      status = film::PixelFilter::make(
          d->name, x, y,
          [instance, functions](double u, double v) { return functions->value(instance->data(), u, v); }, out);
      if (status.ok()) return;
    }
  } else {
    status = film::PixelFilter::make(scene.pixelFilter, x, y, out);
  }
  if (!status.ok()) diagnostics.warning("FILM-FILTER", scene.pos, status.what, "gaussian 2 2 is used");
}

namespace {

using light::LightFilterMode;
constexpr std::pair<const char*, LightFilterMode> kModes[] = {{"mult", LightFilterMode::Multiply},
                                                              {"max", LightFilterMode::Max},
                                                              {"min", LightFilterMode::Min},
                                                              {"screen", LightFilterMode::Screen}};

bool isLightCombiner(const scene::Node& n) { return sameName(n.plugin, "PxrCombinerLightFilter"); }

// Which filters of a light combine: by the combiners among them, the first that names a filter; else by their own
// combineMode.
class FilterGroups {
 public:
  FilterGroups(const std::vector<scene::NodePtr>& filters, Diagnostics& diagnostics) {
    uint32_t group = uint32_t(std::size(kModes));  // the first ones are those without a combiner
    for (const scene::NodePtr& n : filters) {
      if (!isLightCombiner(*n)) continue;
      for (const auto& [name, mode] : kModes) {
        const scene::Parameter* list = n->params.find(name);
        for (const std::string& handle : list ? list->strings : std::vector<std::string>()) {
          const auto it =
              std::find_if(filters.begin(), filters.end(), [&](const auto& f) { return f->handle == handle; });
          if (it == filters.end() || isLightCombiner(**it))
            diagnostics.warning(
                "FILTER-REFERENCE", n->pos,
                n->plugin + " '" + n->handle + "' names the filter '" + handle + "', which is not there",
                "it is left out");
          else
            byHandle_.try_emplace(handle, group, mode);
        }
        ++group;
      }
    }
  }
  void place(const scene::Node& n, light::LightFilterEntry& e) const {
    if (const auto it = byHandle_.find(n.handle); it != byHandle_.end()) {
      std::tie(e.group, e.mode) = it->second;
      return;
    }
    const std::string own = n.params.getString("combineMode", "mult");
    for (const auto& [name, mode] : kModes)
      if (own == name) {
        e.group = uint32_t(mode);
        e.mode = mode;
      }
  }

 private:
  std::map<std::string, std::pair<uint32_t, LightFilterMode>> byHandle_;
};

// The coordinate system of that name in the light's scope; null: none.
const scene::Transform* spaceOf(const scene::Light& light, const std::string& name) {
  const auto* scoped = light.attributes ? light.attributes->coordinateSystems.get() : nullptr;
  const auto it = scoped ? scoped->find(name) : std::map<std::string, scene::Transform>::const_iterator();
  return scoped && it != scoped->end() ? &it->second : nullptr;
}

}  // namespace

namespace {

// The largest factor of a filter wherever it is asked: by objects that are without it, and by light to lobes on which
// it weighs less. A filter without a bound of its own counts as 1, as ever.
float largestWithin(const light::LightFilterEntry& e, float own) {
  float most = own;
  for (const float amount : {e.diffuse, e.specular}) most = std::max(most, 1 + amount * (own - 1));
  return e.linkingGroups.empty() ? most : std::max(most, 1.f);
}

// The same of all of a light's filters, sorted by group; what bounds the light's power must bound how they combine.
float largestTogether(const std::vector<light::LightFilterEntry>& list, const std::map<const void*, float>& own) {
  float all = 1;
  for (size_t i = 0, end; i < list.size(); i = end) {
    const LightFilterMode mode = list[i].mode;
    float most = 0, least = INFINITY, clear = 1;
    for (end = i; end < list.size() && list[end].group == list[i].group; ++end) {
      const float f = largestWithin(list[end], own.at(list[end].instance));
      if (mode == LightFilterMode::Multiply) all *= f;
      most = std::max(most, f);
      if (list[end].linkingGroups.empty()) least = std::min(least, f);
      clear *= 1 - std::min(f, 1.f);
    }
    if (mode == LightFilterMode::Min && std::isfinite(least))
      all *= least;
    else if (mode == LightFilterMode::Screen)
      all *= std::max(most, 1 - clear);
    else if (mode != LightFilterMode::Multiply)
      all *= most;
  }
  return all;
}

}  // namespace

std::vector<light::LightFilterEntry> makeLightFilters(const scene::Light& light, const scene::Scene& scene,
                                                      const CameraState& camera, Registry& registry, const Host& host,
                                                      Diagnostics& diagnostics, float& largestFactor) {
  std::vector<light::LightFilterEntry> list;
  std::map<const void*, float> largest;
  const FilterGroups groups(light.filters, diagnostics);
  const Placement lightPlace = placementOf(light.toWorld, camera);
  const LightFilterInfo info{&lightPlace};
  for (const scene::NodePtr& n : light.filters) {
    if (isLightCombiner(*n)) continue;
    const Descriptor* d = registry.find(Kind::LightFilter, n->plugin, diagnostics, n->pos);
    if (!d) {
      diagnostics.warning("PLUGIN-MISSING", n->pos, "no light filter '" + n->plugin + "' (node '" + n->handle + "')",
                          "the light is unfiltered by it", adviceOnMissing(Kind::LightFilter, n->plugin));
      continue;
    }
    // a coordinate system by name, else the light's own
    scene::Transform space = light.toWorld;
    if (const std::string name = n->params.getString("coordsys", ""); !name.empty()) {
      const scene::Transform* found = spaceOf(light, name);
      if (const auto it = scene.coordinateSystems.find(name); !found && it != scene.coordinateSystems.end())
        found = &it->second;
      if (!found)
        diagnostics.warning(
            "LIGHT-FILTER-SPACE", n->pos,
            n->plugin + " '" + n->handle + "' names the coordinate system '" + name + "', which is not there",
            "the light's own is used");
      else
        space = *found;
    }
    const Placement place = placementOf(space, camera);
    Instance instance;
    if (!instance.create(*d, n.get(), &place, &info, host, diagnostics)) continue;
    light::LightFilterEntry e;
    bool usable = true;
    for (uint32_t width : {1u, 4u, 8u, 16u}) {
      e.byWidth[width] = static_cast<const LightFilterFunctions*>(functionsFor(*d, width));
      usable &= e.byWidth[width] && e.byWidth[width]->factor;
    }
    if (!usable) continue;
    e.owner = instance.owner();
    e.instance = instance.data();
    e.motion = movesOf(space, camera).motion;
    float own = 1;
    if (const auto* traits = static_cast<const LightFilterTraits*>(d->traits)) {
      e.isUniform = traits->isUniform && traits->isUniform(e.instance);
      if (traits->largest) own = std::max(0.f, traits->largest(e.instance));
    }
    largest[e.instance] = own;
    const auto amount = [&](const char* name) {
      const float a = n->params.getFloat(name, 1);
      if (a >= 0 && a <= 1) return a;
      diagnostics.warning("PARAM-RANGE", n->pos,
                          n->plugin + " '" + n->handle + "': " + name + " is not within 0 to 1",
                          "it is brought within");
      return a > 1 ? 1.f : 0.f;
    };
    e.diffuse = amount("diffuse");
    e.specular = amount("specular");
    e.linkingGroups = n->params.getString("linkingGroups", "");
    groups.place(*n, e);
    list.push_back(std::move(e));
  }
  std::stable_sort(list.begin(), list.end(), [](const auto& a, const auto& b) { return a.group < b.group; });
  largestFactor = largestTogether(list, largest);
  return list;
}

}  // namespace kinora::render
