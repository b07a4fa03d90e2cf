// What `kinora plugins` prints, over a plug-in of the test's own and over the whole registry; and that
// docs/plugins.md and docs/plugins/*.md are what the program prints, with a picture where one is shown and no page of
// what is no more. Misses: whether the help is true, and whether pictures are up to date.
#include "app/plugin_manual.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "base/text.h"
#include "plugin/refused.h"
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

TEST(PluginManual, TheListKeepsNamesAndHelpApart) {
  Descriptor long_ = kDescriptor;
  long_.name = "AnExampleOfAPlugInWithALongName";
  const std::string list = pluginList({&kDescriptor, &long_});
  EXPECT_NE(list.find("AnExampleOfAPlugInWithALongName  For the test."), std::string::npos) << list;
  const size_t second = list.find('\n') + 1;
  EXPECT_EQ(list.find("For"), list.find("For", second) - second) << "one column\n" << list;
}

TEST(PluginManual, MarkdownKeepsTablesWhole) {
  const std::string page = pluginPage(kDescriptor);
  EXPECT_NE(page.find("| `gain` | float | 0.18 | 0 .. 2 | A factor. |"), std::string::npos) << page;
  EXPECT_NE(page.find("A colour \\| with a bar."), std::string::npos) << page;
}

// The index lists them all (CommittedPagesAreWhatTheProgramPrints compares it); what is in stock is not refused, and
// a message tells the reason.
TEST(PluginManual, WhatIsRefusedIsNotInStockAndHasAReason) {
  const std::string index = pluginsMarkdown(stockPlugins());
  std::set<std::pair<Kind, std::string>> names;
  for (const RefusedPlugin& r : refusedPlugins()) {
    EXPECT_TRUE(names.insert({r.kind, r.name}).second) << r.name << " stands twice";
    EXPECT_TRUE(*r.why) << r.name;
    EXPECT_NE(index.find(std::string("| ") + r.name + " | " + r.why), std::string::npos) << r.name;
    EXPECT_NE(adviceOnMissing(r.kind, r.name).find(r.why), std::string::npos);
    for (const Descriptor* d : stockPlugins())
      EXPECT_FALSE(d->kind == r.kind && sameName(d->name, r.name)) << r.name << " is in stock";
  }
  EXPECT_FALSE(names.empty());
  EXPECT_EQ(adviceOnMissing(Kind::Pattern, "MyOwn"), "is its library on the plug-in path?");
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

const std::filesystem::path kDocs = KINORA_SOURCE_DIR "/docs";

std::string textOf(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::stringstream text;
  text << stream.rdbuf();
  return text.str();
}

TEST(PluginManual, CommittedPagesAreWhatTheProgramPrints) {
  EXPECT_EQ(textOf(kDocs / "plugins.md"), pluginsMarkdown(stockPlugins())) << "run: tools/make_plugin_pages --text";
  std::set<std::string> expected{"images"};
  std::set<std::string> pictures;
  for (const Descriptor* d : stockPlugins()) {
    const std::string name = d->name;
    EXPECT_TRUE(expected.insert(name + ".md").second) << name << ": two plug-ins would share a page";
    EXPECT_EQ(textOf(kDocs / "plugins" / (name + ".md")), pluginPage(*d)) << "run: tools/make_plugin_pages --text";
    if (!hasPicture(*d)) continue;
    pictures.insert(name + ".jpg");
    const auto picture = kDocs / "plugins/images" / (name + ".jpg");
    ASSERT_TRUE(std::filesystem::exists(picture)) << "run: tools/make_plugin_pages " << name;
    EXPECT_GT(std::filesystem::file_size(picture), 500u) << name;
    EXPECT_LT(std::filesystem::file_size(picture), 32u << 10) << name;
  }
  for (const auto& e : std::filesystem::directory_iterator(kDocs / "plugins"))
    EXPECT_TRUE(expected.count(e.path().filename())) << e.path() << " is no stock plug-in's page";
  for (const auto& e : std::filesystem::directory_iterator(kDocs / "plugins/images"))
    EXPECT_TRUE(pictures.count(e.path().filename())) << e.path() << " is no page's picture";
}

}  // namespace
}  // namespace kinora::app
