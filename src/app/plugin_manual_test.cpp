// What `kinora plugins` prints, over a plug-in of the test's own and over the whole registry; and that
// docs/plugins.md is what the program prints. Misses: whether the help is true.
#include "app/plugin_manual.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "plugin/registry.h"

namespace kinora::app {
namespace {

constexpr Param kParams[] = {
    param::color("tint", 1, 0.5f, 0.25f).help("A colour | with a bar."),
    param::number("gain", 0.18f).range(0, 2).help("A factor."),
    param::integer("mode", 1).range(0, 1).options("0 off, 1 on"),
    param::string("name", "st").file(),
    param::output(Type::Color, "resultRGB"),
};
const Descriptor kDescriptor{kAbiVersion, sizeof(Descriptor), Kind::Pattern, 0, "Example", "For the test.",
                             kParams,     std::size(kParams), nullptr,       0, nullptr,   nullptr,
                             nullptr};

TEST(PluginManual, TextHoldsTypesDefaultsRangesAndHelp) {
  const std::string text = pluginText(kDescriptor);
  for (const char* part : {"Example (pattern)", "color    = 1 0.5 0.25", "float    = 0.18  (0 .. 2)", "A factor.",
                           "(0 off, 1 on)", "string   = \"st\"", "A texture file.", "Outputs", "resultRGB"})
    EXPECT_NE(text.find(part), std::string::npos) << part << "\nin\n" << text;
}

TEST(PluginManual, MarkdownKeepsTablesWhole) {
  const std::string page = pluginsMarkdown({&kDescriptor});
  EXPECT_NE(page.find("| `gain` | float | 0.18 | 0 .. 2 | A factor. |"), std::string::npos) << page;
  EXPECT_NE(page.find("A colour \\| with a bar."), std::string::npos) << page;
}

TEST(PluginManual, EveryStockPluginExplainsItself) {
  for (const Descriptor* d : stockPlugins()) {
    EXPECT_TRUE(d->doc && *d->doc) << d->name;
    for (uint32_t i = 0; i < d->paramCount; ++i) {
      if (d->params[i].flags & kParamOutput) continue;
      EXPECT_TRUE(d->params[i].doc && *d->params[i].doc) << d->name << "." << d->params[i].name;
    }
  }
}

TEST(PluginManual, CommittedPageIsWhatTheProgramPrints) {
  std::ifstream stream(KINORA_SOURCE_DIR "/docs/plugins.md");
  ASSERT_TRUE(stream) << "docs/plugins.md is missing";
  std::stringstream committed;
  committed << stream.rdbuf();
  EXPECT_EQ(committed.str(), pluginsMarkdown(stockPlugins()))
      << "run: build/kinora plugins --markdown > docs/plugins.md";
}

}  // namespace
}  // namespace kinora::app
