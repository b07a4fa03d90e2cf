// A node of a network with its plug-in or shader and its values, on its way into a program. For the files of MaterialSet
// alone.
#pragma once
#include <memory>
#include <vector>

#include "shade/material.h"
#include "shade/shader_parameters.h"

namespace kinora::shade {

struct MaterialSet::Resolved {
  const Descriptor* plugin;
  std::shared_ptr<const ShaderNode> shader;
  const scene::Node* node;
  std::unique_ptr<ResolvedParams> values;
  struct Link {
    int node = -1;
    uint32_t output = 0;
    int32_t part = -1;
  };
  std::vector<Link> links;  // by parameter
  std::vector<PartReference> wantedParts;
  std::vector<PartSource> parts;
};

}  // namespace kinora::shade
