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

// The nodes that run, in order. A combiner may name combiners, but no one that it is named by itself.
class ActiveNodes {
 public:
  ActiveNodes(const std::vector<scene::NodePtr>& nodes, Diagnostics& diagnostics)
      : nodes_(nodes), diagnostics_(diagnostics) {
    if (!nodes.empty()) add(nodes.back());
  }
  const std::vector<scene::NodePtr>& order() const { return order_; }

 private:
  static constexpr size_t kMost = 4096;  // combiners that name one another twice double with each level
  void add(const scene::NodePtr& node) {
    if (!isCombiner(*node)) {
      if (order_.size() < kMost) order_.push_back(node);
      return;
    }
    open_.push_back(node.get());
    const scene::Parameter* filter = node->params.find("filter");
    for (const std::string& handle : filter ? filter->strings.get() : std::vector<std::string>()) {
      if (++named_ > kMost) break;
      const auto it = std::find_if(nodes_.begin(), nodes_.end(), [&](const auto& n) { return n->handle == handle; });
      if (it == nodes_.end())
        leaveOut(*node, handle, "which is not there");
      else if (std::find(open_.begin(), open_.end(), it->get()) != open_.end())
        leaveOut(*node, handle, "by which it is named itself");
      else
        add(*it);
    }
    open_.pop_back();
  }
  void leaveOut(const scene::Node& combiner, const std::string& handle, const std::string& why) {
    diagnostics_.warning("FILTER-REFERENCE", combiner.pos,
                         combiner.plugin + " '" + combiner.handle + "' names the filter '" + handle + "', " + why,
                         "it is left out");
  }
  const std::vector<scene::NodePtr>& nodes_;
  Diagnostics& diagnostics_;
  std::vector<const scene::Node*> open_;  // combiners around
  std::vector<scene::NodePtr> order_;
  size_t named_ = 0;
};

// The channels of one name, as film/display_plan.h names them apart.
std::vector<int> variantsOf(const film::ChannelLayout& layout, int first) {
  std::vector<int> list;
  std::string name = layout[first].name;
  for (int at = first; at >= 0; at = layout.find(name += "'")) list.push_back(at);
  return list;
}

// How much speaks for two channels being of one display.
int likeness(const film::Channel& a, const film::Channel& b) {
  return 16 * (a.filter == b.filter) + 8 * (a.reducer == b.reducer) + 4 * (a.statistic == b.statistic) +
         2 * (a.half == b.half) + (a.remap == b.remap);
}

}  // namespace

void FilterChain::make(Kind kind, const std::vector<scene::NodePtr>& nodes, const film::ChannelLayout& layout,
                       const ChannelFilterInfo& picture, Registry& registry, const Host& host, uint32_t width,
                       Diagnostics& diagnostics) {
  kind_ = kind;
  steps_.clear();
  const ActiveNodes active(nodes, diagnostics);
  for (const scene::NodePtr& n : active.order()) {
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
    Run first;
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
      first.push_back(std::move(c));
    }
    addRuns(layout, std::move(first), step);
    steps_.push_back(std::move(step));
  }
}

// Each run has, beside a channel, those of the other names that are the most alike. What several runs have in common
// the first of them changes: samples' records by the record, since channels share those.
void FilterChain::addRuns(const film::ChannelLayout& layout, Run first, Step& step) const {
  const auto placeOf = [&](const Channel& c) { return kind_ == Kind::SampleFilter ? c.record : c.layoutIndex; };
  const auto isSame = [&](const Channel& a, const Channel& b) {
    return (a.layoutIndex < 0) == (b.layoutIndex < 0) && (a.layoutIndex < 0 || placeOf(a) == placeOf(b));
  };
  // a filter of pictures makes nothing of their variance
  const auto mayBe = [&](const Channel& c, int at) {
    return layout[at].width == c.width &&
           (kind_ == Kind::SampleFilter || layout[at].statistic == film::Statistic::Value);
  };
  std::vector<int> places;
  const auto add = [&](Run run) {
    for (const Run& before : step.runs)
      if (std::equal(run.begin(), run.end(), before.begin(), before.end(), isSame)) return;
    bool isNew = step.runs.empty();
    for (Channel& c : run) {
      if (c.layoutIndex < 0) continue;
      const int place = placeOf(c);
      c.isCopy = !step.runs.empty() && std::find(places.begin(), places.end(), place) != places.end();
      isNew |= !c.isCopy;
    }
    if (!isNew) return;
    for (const Channel& c : run)
      if (c.layoutIndex >= 0) places.push_back(placeOf(c));
    step.runs.push_back(std::move(run));
  };
  add(first);
  for (const Channel& named : first) {
    if (named.layoutIndex < 0) continue;
    for (const int variant : variantsOf(layout, named.layoutIndex)) {
      if (variant == named.layoutIndex || !mayBe(named, variant)) continue;
      Run run = first;
      for (Channel& c : run) {
        if (c.layoutIndex < 0) continue;
        int best = c.layoutIndex;
        if (c.layoutIndex == named.layoutIndex) {
          best = variant;
        } else {
          for (const int other : variantsOf(layout, c.layoutIndex))
            if (mayBe(c, other) && likeness(layout[other], layout[variant]) > likeness(layout[best], layout[variant]))
              best = other;
        }
        c.layoutIndex = best;
        c.record = layout.recordOffset(best);
      }
      add(std::move(run));
    }
  }
}

bool FilterChain::uses(const std::string& name) const {
  for (const Step& step : steps_)
    for (const Channel& c : step.runs[0])
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
  std::vector<std::vector<float>> copies;  // of what earlier runs of a step change
  for (const Step& step : steps_) {
    copies.clear();
    for (const Run& run : step.runs)
      for (const Channel& c : run)
        for (int k = 0; k < c.width && c.isCopy; ++k)
          copies.emplace_back(records[c.record + k], records[c.record + k] + padded(count));
    size_t copy = 0;
    for (const Run& run : step.runs) {
      uint32_t n = 0;
      for (const Channel& c : run) {
        FilterChannel f{c.name.c_str(), 0, {}, {}};
        if (c.layoutIndex >= 0) {
          f.components = uint32_t(c.width);
          for (int k = 0; k < c.width; ++k) f.data[k] = c.isCopy ? copies[copy++].data() : records[c.record + k];
        }
        list[n++] = f;
      }
      call(step, {count, x, y, list, n, {}});
    }
  }
}

film::FilteredPixels FilterChain::run(const film::Film& film) const {
  film::FilteredPixels out;
  out.window = film.window();
  const int w = out.window.width();
  const auto eachChannel = [](const Step& step, auto&& visit) {  // visit(channel, its number in the step)
    size_t at = 0;
    for (const Run& run : step.runs)
      for (const Channel& c : run) visit(c, at++);
  };
  for (const Step& step : steps_)
    eachChannel(step, [&](const Channel& c, size_t) {
      if (c.layoutIndex < 0 || out.channels.contains(c.layoutIndex)) return;
      auto& channel = out.channels[c.layoutIndex];
      channel.width = c.width;
      channel.values.resize(size_t(out.window.pixels()) * size_t(c.width));
      float* to = channel.values.data();
      for (int y = out.window.y0; y < out.window.y1; ++y)
        for (int x = out.window.x0; x < out.window.x1; ++x, to += c.width) film.resolvePixel(c.layoutIndex, x, y, to);
    });
  const uint32_t most = padded(uint32_t(w) * kRows);
  std::vector<int32_t> xs(most), ys(most);
  std::vector<std::vector<float>> planes, before;
  for (const Step& step : steps_) {
    const size_t channels = step.runs.size() * step.runs[0].size();
    before.assign(step.seesPicture ? channels * 3 : 0, {});
    eachChannel(step, [&](const Channel& c, size_t at) {
      if (!step.seesPicture || c.layoutIndex < 0) return;
      const film::FilteredPixels::Channel& whole = out.channels[c.layoutIndex];
      for (size_t q = 0; q < size_t(whole.width); ++q) {
        std::vector<float>& plane = before[3 * at + q];
        plane.resize(size_t(out.window.pixels()));
        for (size_t i = 0; i < plane.size(); ++i) plane[i] = whole.values[i * size_t(whole.width) + q];
      }
    });
    planes.assign(channels * 3, std::vector<float>(most, 0.f));
    std::vector<FilterChannel> list(channels);
    for (int y0 = out.window.y0; y0 < out.window.y1; y0 += kRows) {
      const uint32_t n = uint32_t(w) * uint32_t(std::min(kRows, out.window.y1 - y0));
      const size_t first = size_t(y0 - out.window.y0) * size_t(w);
      for (uint32_t i = 0; i < padded(n); ++i) {
        const uint32_t j = std::min(i, n - 1);
        xs[i] = out.window.x0 + int32_t(j % uint32_t(w));
        ys[i] = y0 + int32_t(j / uint32_t(w));
      }
      eachChannel(step, [&](const Channel& c, size_t at) {
        FilterChannel f{c.name.c_str(), 0, {}, {}};
        if (c.layoutIndex >= 0) {
          f.components = uint32_t(c.width);
          const float* from = out.channels[c.layoutIndex].values.data() + first * size_t(c.width);
          for (int q = 0; q < c.width; ++q) {
            f.data[q] = planes[3 * at + size_t(q)].data();
            for (uint32_t i = 0; i < padded(n); ++i)
              f.data[q][i] = from[size_t(std::min(i, n - 1)) * size_t(c.width) + size_t(q)];
            if (step.seesPicture) f.before[q] = before[3 * at + size_t(q)].data();
          }
        }
        list[at] = f;
      });
      const size_t each = step.runs[0].size();
      for (size_t r = 0; r < step.runs.size(); ++r)
        call(step, {n,
                    xs.data(),
                    ys.data(),
                    list.data() + r * each,
                    uint32_t(each),
                    {out.window.x0, out.window.y0, out.window.x1, out.window.y1}});
      eachChannel(step, [&](const Channel& c, size_t at) {
        if (c.layoutIndex < 0 || c.isCopy) return;
        float* to = out.channels[c.layoutIndex].values.data() + first * size_t(c.width);
        for (int q = 0; q < c.width; ++q)
          for (uint32_t i = 0; i < n; ++i) to[size_t(i) * size_t(c.width) + size_t(q)] = list[at].data[q][i];
      });
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
        for (const std::string& handle : list ? list->strings.get() : std::vector<std::string>()) {
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
