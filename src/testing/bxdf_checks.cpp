#include <kinora/testing/bxdf_checks.h>

#include <algorithm>

#include "testing/bxdf_case.h"

namespace kinora::testing {

namespace {

// Why a descriptor cannot be checked at all; "" when it can.
std::string unusable(const Descriptor& d) {
  if (d.kind != Kind::Bxdf) return "not a bxdf";
  if (!d.traits) return "has no BxdfTraits";
  const BxdfTraits& t = *static_cast<const BxdfTraits*>(d.traits);
  if (t.lobeCount > kMaxLobes || (t.lobeCount && !t.lobes))
    return "declares more lobes than there are, or none of its list";
  if (t.presenceParam >= int(d.paramCount)) return "presenceParam is not a parameter";
  const auto tables = runnableTables(d);
  if (tables.empty()) return "has no function table that this CPU runs";
  for (const WidthTable* table : tables) {
    const BxdfFunctions& f = *static_cast<const BxdfFunctions*>(table->functions);
    if (!f.begin || !f.generate || !f.evaluate || !f.evaluateAt)
      return "lacks begin, generate, evaluate or evaluateAt";
    if ((d.flags & kBxdfFillsSpace) && !f.medium) return "fills space, and lacks medium";
  }
  return {};
}

BxdfCase makeCase(const Descriptor& d, const Setting& s) {
  BxdfCase c{d, *static_cast<const BxdfTraits*>(d.traits), s, runnableTables(d)};
  std::sort(c.tables.begin(), c.tables.end(), [](auto* a, auto* b) { return a->width < b->width; });
  const ResolvedValues values(d, s);
  c.encloses = c.traits.enclosesMedium && c.traits.enclosesMedium(values.data(), values.count());
  c.fillsSpace = d.flags & kBxdfFillsSpace;
  c.reciprocal = !(d.flags & kBxdfNotReciprocal);
  c.isFiber = d.flags & kBxdfFiber;
  for (uint32_t i = 0; i < d.paramCount; ++i)
    if (d.params[i].type == Type::Normal)
      for (const float x : s.numbers[i]) c.bumped = c.bumped || x != 0;
  return c;
}

enum class Depth { Points, Some, Full };

void checkSetting(Judge& judge, const Descriptor& d, const Setting& s, Depth depth, bool lossless, bool conserving,
                  uint64_t seed, const BxdfCheckOptions& o) {
  judge.setSetting(s.text);
  const BxdfCase c = makeCase(d, s);
  checkBxdfPoints(judge, c, seed);
  if (depth == Depth::Points) return;
  StatisticsPlan plan;
  plan.lossless = lossless;
  plan.conserving = conserving;
  plan.samples = o.samples;
  if (depth == Depth::Some) {
    const double cosines[] = {0.95, 0.6, 0.2};
    plan.cosine = cosines[seed % 3];
    plan.outside = !c.encloses || seed % 2;
    checkBxdfStatistics(judge, c, plan, seed);
    return;
  }
  plan.samples = 4 * o.samples;
  plan.precise = true;
  for (const double cosine : {0.98, 0.6, 0.2}) {
    plan.cosine = cosine;
    plan.outside = true;
    checkBxdfStatistics(judge, c, plan, ++seed);
    plan.outside = false;
    if (c.encloses) checkBxdfStatistics(judge, c, plan, ++seed);
  }
}

}  // namespace

CheckReport checkBxdf(const Descriptor& bxdf, const Setting& setting, const BxdfCheckOptions& options) {
  Judge judge(bxdf.name);
  if (const std::string why = unusable(bxdf); !why.empty()) {
    judge.fail("declaration", why);
    return judge.finish();
  }
  checkSetting(judge, bxdf, setting, Depth::Full, false, false, options.seed, options);
  return judge.finish();
}

CheckReport checkBxdf(const Descriptor& bxdf, const BxdfCheckOptions& options) {
  Judge judge(bxdf.name);
  if (const std::string why = unusable(bxdf); !why.empty()) {
    judge.fail("declaration", why);
    return judge.finish();
  }
  const BxdfTraits& traits = *static_cast<const BxdfTraits*>(bxdf.traits);
  // declared settings; one that stands in both lists is run once
  struct Declared {
    std::string text;
    bool lossless, conserving;
  };
  std::vector<Declared> declared;
  for (const char* const* t = traits.lossless; t && *t; ++t) declared.push_back({*t, true, true});
  for (const char* const* t = traits.conserving; t && *t; ++t)
    if (std::none_of(declared.begin(), declared.end(), [&](const Declared& d) { return d.text == *t; }))
      declared.push_back({*t, false, true});
  uint64_t seed = options.seed * 1000003;
  for (const Declared& d : declared) {
    Setting s;
    std::string error;
    if (!parseSetting(bxdf, d.text, s, error)) {
      judge.fail("declaration", "setting '" + d.text + "': " + error);
      continue;
    }
    checkSetting(judge, bxdf, s, Depth::Full, d.lossless, d.conserving, seed += 17, options);
  }
  const std::vector<Setting> settings = coveringSettings(bxdf, options.randomSettings, options.seed);
  const uint32_t every = std::max<uint32_t>(1, uint32_t(settings.size()) / std::max(1u, options.statisticalSettings));
  for (size_t i = 0; i < settings.size(); ++i) {
    const Depth depth = i == 0                                                           ? Depth::Full
                        : (i + options.seed) % every == 0 && options.statisticalSettings ? Depth::Some
                                                                                         : Depth::Points;
    checkSetting(judge, bxdf, settings[i], depth, false, false, seed += 17, options);
  }
  return judge.finish();
}

}  // namespace kinora::testing
