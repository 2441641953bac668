// VTK as a peer of isolux.
//   vtk_peer mesh|volume|step THREADS      then the requests of bench/README.md on standard input

#include <vtkCamera.h>
#include <vtkLight.h>
#include <vtkMultiThreader.h>
#include <vtkPointData.h>
#include <vtkSMPTools.h>
#include <vtkUnsignedCharArray.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <sstream>
#include <stdexcept>

#include "isolux/bench/line_protocol.h"
#include "isolux/bench/ppm.h"
#include "own_display.h"
#include "vtk_stage.h"

namespace {

using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

using Triple = std::array<double, 3>;

Triple read_triple(std::istringstream& words) {
  Triple v{};
  words >> v[0] >> v[1] >> v[2];
  return v;
}

class VtkPeer {
 public:
  explicit VtkPeer(std::unique_ptr<Showing> showing) : showing_(std::move(showing)) {
    showing_->add_to(renderer_);
    renderer_->SetBackground(0, 0, 0);
    renderer_->AutomaticLightCreationOff();
    renderer_->AddLight(light_);
    window_->SetOffScreenRendering(1);
    window_->SetMultiSamples(0);
    window_->AddRenderer(renderer_);
    put_headlight();
  }

  std::string size(std::istringstream& words) {
    int width = 0, height = 0;
    words >> width >> height;
    window_->SetSize(width, height);
    return {};
  }

  std::string volume(std::istringstream& words) {
    std::string path;
    std::array<int, 3> dims{};
    words >> path >> dims[0] >> dims[1] >> dims[2];
    const Triple spacing = read_triple(words);
    volume_ = vtkSmartPointer<vtkImageData>::New();
    volume_->SetDimensions(dims.data());
    volume_->SetSpacing(spacing.data());
    volume_->AllocateScalars(VTK_SHORT, 1);
    std::ifstream file(path, std::ios::binary);
    file.read(static_cast<char*>(volume_->GetScalarPointer()),
              static_cast<std::streamsize>(2 * volume_->GetNumberOfPoints()));
    if (!file) throw std::runtime_error("cannot read " + path + ", or it is too short");
    return {};
  }

  std::string iso(std::istringstream& words) {
    double value = 0;
    words >> value;
    if (!volume_) throw std::runtime_error("there is no volume; send `volume` first");
    const auto begin = Clock::now();
    showing_->set_iso(volume_, value);
    const double ms = ms_since(begin);
    volume_->GetBounds(bounds_.data());
    return std::to_string(ms);
  }

  std::string read_mesh_file(std::istringstream& words) {
    std::string path;
    words >> path;
    const Mesh mesh = isolux::read_peer_mesh(path);
    const auto begin = Clock::now();
    showing_->set_mesh(mesh);
    const double ms = ms_since(begin);
    vtkSmartPointer<vtkPolyData>(*showing_->surface())->GetBounds(bounds_.data());
    return std::to_string(ms);
  }

  std::string write_mesh_file(std::istringstream& words) {
    std::string path;
    words >> path;
    const vtkSmartPointer<vtkPolyData>* surface = showing_->surface();
    if (!surface || !*surface) throw std::runtime_error("there is no mesh");
    isolux::write_peer_mesh(path, mesh_of(*surface));
    return {};
  }

  std::string lamp(std::istringstream& words) {
    light_->SetLightTypeToSceneLight();
    light_->SetPositional(true);
    light_->SetConeAngle(180);  // no spot, but to all sides
    light_->SetPosition(read_triple(words).data());
    return {};
  }

  std::string headlight(std::istringstream&) {
    put_headlight();
    return {};
  }

  std::string frame(std::istringstream& words) {
    const Triple eye = read_triple(words), target = read_triple(words);
    double fov_deg = 0;
    words >> fov_deg;
    if (!(bounds_[0] <= bounds_[1])) {
      throw std::runtime_error("there is no surface; send `iso` or `read-mesh` first");
    }
    vtkCamera* camera = renderer_->GetActiveCamera();
    camera->SetPosition(eye.data());
    camera->SetFocalPoint(target.data());
    camera->SetViewUp(0, 0, 1);
    camera->SetViewAngle(fov_deg);
    set_clipping(eye);
    const auto begin = Clock::now();
    window_->Render();
    window_->WaitForCompletion();
    const double ms = ms_since(begin);
    const isolux::Ppm shown = read_back();
    return std::to_string(ms) + " " + std::to_string(lit_pixels(shown)) + " " +
           std::to_string(isolux::checksum_of(shown.rgb.data(), shown.rgb.size()));
  }

  std::string picture(std::istringstream& words) {
    std::string path;
    words >> path;
    const isolux::Ppm shown = read_back();
    isolux::write_ppm(path, shown.width, shown.height, shown.rgb);
    return {};
  }

 private:
  void put_headlight() {
    light_->SetLightTypeToHeadlight();
    light_->SetPositional(false);
  }

  // From a little before the eye, or where the box begins, to where it ends.
  void set_clipping(const Triple& eye) {
    double square_size = 0, square_distance = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double low = bounds_[2 * axis], high = bounds_[2 * axis + 1];
      square_size += (high - low) * (high - low);
      square_distance += std::pow(eye[axis] - (low + high) / 2, 2);
    }
    const double radius = std::sqrt(square_size) / 2, distance = std::sqrt(square_distance);
    renderer_->GetActiveCamera()->SetClippingRange(
        std::max(0.007 * radius, distance - 1.05 * radius), distance + 1.05 * radius);
  }

  // VTK's rows go from the bottom up.
  isolux::Ppm read_back() {
    const int* size = window_->GetSize();
    const int width = size[0], height = size[1];
    const vtkNew<vtkUnsignedCharArray> pixels;
    window_->GetPixelData(0, 0, width - 1, height - 1, /*front=*/0, pixels);
    isolux::Ppm shown{width, height, {}};
    const auto row_bytes = 3 * static_cast<std::size_t>(width);
    for (int row = height - 1; row >= 0; --row) {
      const unsigned char* begin =
          pixels->GetPointer(0) + row_bytes * static_cast<std::size_t>(row);
      shown.rgb.insert(shown.rgb.end(), begin, begin + row_bytes);
    }
    return shown;
  }

  static std::size_t lit_pixels(const isolux::Ppm& shown) {
    std::size_t lit = 0;
    for (std::size_t n = 0; n < shown.rgb.size(); n += 3) {
      lit += shown.rgb[n] > 0 || shown.rgb[n + 1] > 0 || shown.rgb[n + 2] > 0;
    }
    return lit;
  }

  std::unique_ptr<Showing> showing_;
  vtkSmartPointer<vtkImageData> volume_;
  std::array<double, 6> bounds_{0,  -1, 0,
                                -1, 0,  -1};  ///< of what is shown: low and high of x, y, z
  vtkNew<vtkRenderer> renderer_;
  vtkNew<vtkRenderWindow> window_;
  vtkNew<vtkLight> light_;
};

std::unique_ptr<Showing> showing_named(const std::string& name, int threads) {
  if (name == "mesh") return make_mesh_showing();
  if (name == "volume") return make_volume_showing(threads);
  if (name == "step") return make_step_showing(threads);
  throw std::runtime_error("the first argument is mesh, volume or step");
}

void answer(const std::string& way, int threads) {
  vtkMultiThreader::SetGlobalMaximumNumberOfThreads(threads);
  vtkSMPTools::Initialize(threads);
  // Mesa without a graphics card, on as many threads.
  ::setenv("LIBGL_ALWAYS_SOFTWARE", "1", 1);
  ::setenv("GALLIUM_DRIVER", "llvmpipe", 1);
  ::setenv("LP_NUM_THREADS", std::to_string(threads).c_str(), 1);
  const OwnDisplay display;
  std::unique_ptr<Showing> showing = showing_named(way, threads);
  const std::string name = showing->name();
  VtkPeer peer(std::move(showing));
  const auto answering = [&](std::string (VtkPeer::*request)(std::istringstream&)) {
    return [&peer, request](std::istringstream& words) { return (peer.*request)(words); };
  };
  isolux::answer_requests(name, {{"size", answering(&VtkPeer::size)},
                                 {"volume", answering(&VtkPeer::volume)},
                                 {"iso", answering(&VtkPeer::iso)},
                                 {"write-mesh", answering(&VtkPeer::write_mesh_file)},
                                 {"read-mesh", answering(&VtkPeer::read_mesh_file)},
                                 {"lamp", answering(&VtkPeer::lamp)},
                                 {"headlight", answering(&VtkPeer::headlight)},
                                 {"frame", answering(&VtkPeer::frame)},
                                 {"picture", answering(&VtkPeer::picture)}});
}

}  // namespace

int main(int count, char** arguments) {
  try {
    if (count != 3) throw std::runtime_error("usage: vtk_peer mesh|volume|step THREADS");
    answer(arguments[1], std::max(1, std::atoi(arguments[2])));
  } catch (const std::exception& error) {
    std::cerr << "vtk_peer: " << error.what() << "\n";
    return 1;
  }
}
