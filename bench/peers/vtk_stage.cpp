#include "vtk_stage.h"

#include <vtkActor.h>
#include <vtkCellArray.h>
#include <vtkCellArrayIterator.h>
#include <vtkColorTransferFunction.h>
#include <vtkDataArray.h>
#include <vtkFixedPointVolumeRayCastMapper.h>
#include <vtkFloatArray.h>
#include <vtkFlyingEdges3D.h>
#include <vtkPiecewiseFunction.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkVersion.h>
#include <vtkVolume.h>

#include <vtkVolumeProperty.h>
#include <algorithm>
#include <stdexcept>

namespace {

const std::string kVtk = std::string("VTK ") + vtkVersion::GetVTKVersion();

// isolux's default material, as near as VTK has it (its highlight is Blinn's).
template <typename Property>
void set_material(Property* property) {
  property->SetAmbient(.1);
  property->SetDiffuse(.8);
  property->SetSpecular(.3);
  property->SetSpecularPower(40);
}

vtkSmartPointer<vtkFloatArray> triples_of(const std::vector<float>& values) {
  auto triples = vtkSmartPointer<vtkFloatArray>::New();
  triples->SetNumberOfComponents(3);
  triples->SetNumberOfTuples(static_cast<vtkIdType>(values.size() / 3));
  std::copy(values.begin(), values.end(), triples->GetPointer(0));
  return triples;
}

vtkSmartPointer<vtkPolyData> poly_data_of(const Mesh& mesh) {
  const vtkNew<vtkPoints> points;
  points->SetData(triples_of(mesh.positions));
  const vtkNew<vtkCellArray> cells;
  for (std::size_t n = 0; n + 2 < mesh.triangles.size(); n += 3) {
    cells->InsertNextCell({mesh.triangles[n], mesh.triangles[n + 1], mesh.triangles[n + 2]});
  }
  auto surface = vtkSmartPointer<vtkPolyData>::New();
  surface->SetPoints(points);
  surface->SetPolys(cells);
  surface->GetPointData()->SetNormals(triples_of(mesh.normals));
  return surface;
}

class MeshShowing : public Showing {
 public:
  MeshShowing() {
    mapper_->ScalarVisibilityOff();
    actor_->SetMapper(mapper_);
    set_material(actor_->GetProperty());
    actor_->GetProperty()->SetInterpolationToPhong();
  }
  std::string name() const override { return kVtk + " mesh on Mesa"; }
  void set_iso(vtkImageData* volume, double iso) override {
    const vtkNew<vtkFlyingEdges3D> extraction;  // a new one, so that nothing is kept
    extraction->SetInputData(volume);
    extraction->SetValue(0, iso);
    extraction->ComputeNormalsOn();
    extraction->ComputeScalarsOff();
    extraction->Update();
    surface_ = extraction->GetOutput();
    mapper_->SetInputData(surface_);
  }
  void set_mesh(const Mesh& mesh) override {
    surface_ = poly_data_of(mesh);
    mapper_->SetInputData(surface_);
  }
  void add_to(vtkRenderer* renderer) override { renderer->AddActor(actor_); }
  const vtkSmartPointer<vtkPolyData>* surface() const override { return &surface_; }

 private:
  vtkNew<vtkPolyDataMapper> mapper_;
  vtkNew<vtkActor> actor_;
  vtkSmartPointer<vtkPolyData> surface_;
};

class VolumeShowing : public Showing {
 public:
  VolumeShowing(bool is_step, int threads) : is_step_(is_step) {
    mapper_->SetNumberOfThreads(threads);
    mapper_->SetBlendModeToComposite();
    property_->SetScalarOpacityUnitDistance(1);
    property_->SetInterpolationTypeToLinear();
    property_->ShadeOn();
    set_material(property_.Get());
    volume_->SetMapper(mapper_);
    volume_->SetProperty(property_);
  }
  std::string name() const override {
    return kVtk + " CPU volume, " + (is_step_ ? "opaque step" : "ct-head");
  }
  void set_iso(vtkImageData* volume, double iso) override {
    mapper_->SetInputData(volume);
    const vtkNew<vtkPiecewiseFunction> opacity;
    const vtkNew<vtkColorTransferFunction> color;
    if (is_step_) {
      opacity->AddPoint(iso - 1, 0);
      opacity->AddPoint(iso, 1);
      color->AddRGBPoint(iso, 1, 1, 1);
    } else {
      const std::vector<std::array<double, 2>> points{{-301, 0}, {-300, .12}, {49, .12},
                                                      {50, 0},   {299, 0},    {300, .8}};
      for (const auto& [value, share] : points) opacity->AddPoint(value, share);
      color->AddRGBPoint(49, 1, .79, .6);
      color->AddRGBPoint(300, 1, 1, 1);
    }
    property_->SetScalarOpacity(opacity);
    property_->SetColor(color);
  }
  void add_to(vtkRenderer* renderer) override { renderer->AddVolume(volume_); }

 private:
  bool is_step_;
  vtkNew<vtkFixedPointVolumeRayCastMapper> mapper_;
  vtkNew<vtkVolumeProperty> property_;
  vtkNew<vtkVolume> volume_;
};

std::vector<float> floats_of(vtkDataArray* triples) {
  std::vector<float> values(3 * static_cast<std::size_t>(triples->GetNumberOfTuples()));
  for (vtkIdType n = 0; n < triples->GetNumberOfTuples(); ++n) {
    const double* triple = triples->GetTuple3(n);
    for (vtkIdType axis = 0; axis < 3; ++axis) {
      values[static_cast<std::size_t>(3 * n + axis)] = static_cast<float>(triple[axis]);
    }
  }
  return values;
}

}  // namespace

void Showing::set_mesh(const Mesh&) { throw std::runtime_error("draws no mesh"); }

std::unique_ptr<Showing> make_mesh_showing() { return std::make_unique<MeshShowing>(); }

std::unique_ptr<Showing> make_volume_showing(int threads) {
  return std::make_unique<VolumeShowing>(false, threads);
}

std::unique_ptr<Showing> make_step_showing(int threads) {
  return std::make_unique<VolumeShowing>(true, threads);
}

Mesh mesh_of(vtkPolyData* surface) {
  Mesh mesh{floats_of(surface->GetPoints()->GetData()),
            floats_of(surface->GetPointData()->GetNormals()),
            {}};
  mesh.triangles.reserve(3 * static_cast<std::size_t>(surface->GetNumberOfPolys()));
  const auto cells = vtk::TakeSmartPointer(surface->GetPolys()->NewIterator());
  for (cells->GoToFirstCell(); !cells->IsDoneWithTraversal(); cells->GoToNextCell()) {
    vtkIdType count = 0;
    const vtkIdType* corners = nullptr;
    cells->GetCurrentCell(count, corners);
    for (vtkIdType n = 0; n < count; ++n) {
      mesh.triangles.push_back(static_cast<std::uint32_t>(corners[n]));
    }
  }
  return mesh;
}
