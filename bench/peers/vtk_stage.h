#pragma once

#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "isolux/bench/mesh_file.h"

using Mesh = isolux::PeerMesh;

/// What VTK draws of a volume at an iso value. One of three ways a user would take.
class Showing {
 public:
  virtual ~Showing() = default;
  virtual std::string name() const = 0;
  /// Makes ready for an iso value, the first frame excepted; the work for it is done here.
  virtual void set_iso(vtkImageData* volume, double iso) = 0;
  virtual void add_to(vtkRenderer* renderer) = 0;
  /// Shows a mesh in place of a volume's surface. Throws where the way goes over none.
  virtual void set_mesh(const Mesh& mesh);
  /// The surface, where the way goes over one.
  virtual const vtkSmartPointer<vtkPolyData>* surface() const { return nullptr; }
};

/// vtkFlyingEdges3D with normals from the volume's gradient, drawn by OpenGL on Mesa's llvmpipe.
std::unique_ptr<Showing> make_mesh_showing();
/// vtkFixedPointVolumeRayCastMapper with automatic sampling and the transfer function `ct-head` of
/// section 9 of the contract, whatever the iso value.
std::unique_ptr<Showing> make_volume_showing(int threads);
/// The same mapper with full opacity above the iso value and none below: the same surface.
std::unique_ptr<Showing> make_step_showing(int threads);

/// The positions, normals and triangles of a surface.
Mesh mesh_of(vtkPolyData* surface);
