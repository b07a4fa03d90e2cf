// What shading knows of geometries, placements and spaces, as the tables of a ShadingWorld. Called by WorldBuilder
// for each world, after what they are of has been made.
#pragma once
#include <vector>

#include "render/camera.h"
#include "render/flat_scene.h"
#include "shade/group.h"

namespace kinora::render {

// Of the geometries of w.world, which are `meshes`, by shape. softTerminator: shadow rays of smooth polygons start from the surface that their normals mean.
void describeGeometries(const scene::Scene& scene, double middle, const FlatScene& flat,
                        const std::vector<const geometry::Mesh*>& meshes, bool softTerminator,
                        shade::ShadingWorld& w);
// Of w.placements, and of the materials that they have.
void describePlacements(const FlatScene& flat, shade::ShadingWorld& w);
void describeSpaces(const scene::Scene& scene, const CameraState& camera, shade::ShadingWorld& w);

// Spheres around what manifold walks go through; `w` has its world, materials and placements. Objects near each other
// share one, so that there are never many.
void describeWalks(const FlatScene& flat, const std::vector<const geometry::Mesh*>& meshes, shade::ShadingWorld& w);

}  // namespace kinora::render
