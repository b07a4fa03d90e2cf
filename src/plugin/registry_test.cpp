// Libraries that cannot be used stay so, with one message. Misses: libraries that can, which the tests of the
// installed package build and load.
#include "plugin/registry.h"

#include <gtest/gtest.h>

#include <fstream>

namespace kinora {
namespace {

TEST(Registry, ALibraryThatFailedFailsAgainInSilence) {
  const std::string file = testing::TempDir() + "kinora_registry_test.so";
  std::ofstream(file) << "no library";
  Diagnostics d([](const std::string&, Severity) {});
  Registry registry;
  for (const std::string& name : {file, std::string("/no/such/library.so")}) {
    EXPECT_FALSE(registry.load(name, d, {}));
    EXPECT_FALSE(registry.load(name, d, {})) << "it did not become usable";
  }
  EXPECT_EQ(d.count("PLUGIN-LOAD"), 2u);
  std::remove(file.c_str());
}

}  // namespace
}  // namespace kinora
