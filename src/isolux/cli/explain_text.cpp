#include "isolux/cli/explain_text.h"

#include <cmath>
#include <numbers>

#include "isolux/base/number_text.h"

namespace isolux {
namespace {

constexpr const char* kChannels[] = {"R", "G", "B"};

std::string num(double value) { return to_text9(value); }
// A number after a binary operator or under a power: negative ones in parentheses.
std::string arg(double value) { return value < 0 ? "(" + num(value) + ")" : num(value); }
std::string tuple(Vec3 v) { return "(" + num(v.x) + ", " + num(v.y) + ", " + num(v.z) + ")"; }
std::string tuple(Rgb c) { return "(" + num(c.r) + ", " + num(c.g) + ", " + num(c.b) + ")"; }

double degrees(double cosine) {
  return std::acos(std::fmin(1, std::fmax(-1, cosine))) * 180 / std::numbers::pi;
}

// Three component-wise expressions as one tuple: (a, b, c).
template <typename Component>
std::string each_axis(const Component& component) {
  std::string text = "(";
  for (int axis = 0; axis < 3; ++axis) text += (axis ? ", " : "") + component(axis);
  return text + ")";
}

std::string dot_text(Vec3 a, Vec3 b) {
  std::string text;
  for (int axis = 0; axis < 3; ++axis)
    text += (axis ? " + " : "") + arg(a[axis]) + " * " + arg(b[axis]);
  return text;
}

class Writer {
 public:
  Writer(const Scene& scene, const Explanation& e)
      : scene_(scene), e_(e), layer_(e.is_hit() ? &e.layers[0] : nullptr) {}

  std::string write(const std::vector<std::string>& surface_names) {
    const Camera& camera = *scene_.camera;
    const std::string pixel = "Pixel (" + std::to_string(e_.x) + ", " + std::to_string(e_.y) +
                              ") of " + std::to_string(camera.width()) + " x " +
                              std::to_string(camera.height());
    if (!e_.is_hit()) {
      line(pixel + ": the eye ray meets no surface, so the pixel shows the background.");
      line("");
      write_display();
      return text_;
    }
    const auto name = [&] {
      return "surface " + std::to_string(layer_->surface) + ", " +
             surface_names[static_cast<std::size_t>(layer_->surface)];
    };
    line(pixel + " shows " + name() + ".");
    write_layer();
    for (std::size_t k = 1; k < e_.layers.size(); ++k) {
      layer_ = &e_.layers[k];
      heading("Layer " + std::to_string(k) + ", seen through those before it: " + name());
      write_layer();
    }
    if (is_plain()) {
      line("");
    } else {
      write_whole();
    }
    write_display();
    return text_;
  }

 private:
  void line(const std::string& text) { text_ += text + "\n"; }
  void heading(const std::string& text) { text_ += "\n" + text + "\n"; }

  const Material& material() const { return layer_->material; }
  const PointTerms& terms() const { return layer_->terms; }

  // Whether the pixel is its one point, and nothing else adds to it.
  bool is_plain() const {
    return e_.layers.size() == 1 && e_.layers[0].weight == 1 && material().kr == Rgb{};
  }

  void write_layer() {
    write_geometry();
    if (scene_.indirect == IndirectMethod::kOff) {
      write_ambient();
    } else {
      write_indirect();
    }
    for (std::size_t n = 0; n < terms().lights.size(); ++n) write_light(n);
    write_sum();
  }

  // Layers by their weights, mirrors, and the background.
  void write_whole() {
    double open = 1;
    heading("The pixel: the layers by their weights, what mirrors show, and the background");
    for (std::size_t k = 0; k < e_.layers.size(); ++k) {
      const double opacity = e_.layers[k].material.opacity;
      line("  weight of layer " + std::to_string(k) + " = opacity * what comes through = " +
           num(opacity) + " * " + num(open) + " = " + num(e_.layers[k].weight));
      open *= 1 - opacity;
    }
    line("  background as far as it is seen = " + tuple(e_.background));
    line("  mirror: kr times what the mirrored rays bring = " + tuple(e_.mirror));
    for (int c = 0; c < 3; ++c) {
      std::string sum;
      for (const ExplainedLayer& layer : e_.layers) {
        sum += num(layer.weight) + " * " + num(layer.terms.total[c]) + " + ";
      }
      line(std::string("  I ") + kChannels[c] + " = " + sum + num(e_.mirror[c]) + " + " +
           num(e_.background[c]) + " = " + num(e_.total[c]));
    }
    line("");
  }

  void write_geometry() {
    const Ray& ray = e_.eye_ray;
    const SurfacePoint& point = terms().point;
    heading("The point and its vectors (world space, mm)");
    line("  o = " + tuple(ray.origin) + "   where the eye ray begins");
    line("  d = " + tuple(ray.direction) + "   its direction");
    line("  t = " + num(layer_->depth_mm) + "   how far it goes until it meets the surface");
    line("  p = o + t d = " + each_axis([&](int a) {
           return num(ray.origin[a]) + " + " + num(layer_->depth_mm) + " * " +
                  arg(ray.direction[a]);
         }) +
         " = " + tuple(point.position));
    line("  n = " + tuple(point.normal) + "   the unit normal" +
         (layer_ != &e_.layers[0] ? ""
          : e_.turned             ? ", turned round to face the eye"
                                  : ", which faces the eye as it is"));
    line("  e = -d = " + tuple(point.to_eye) + "   the unit vector back to the eye");
  }

  void write_ambient() {
    heading("Ambient: I = Ka Ia");
    line("  Ia = " + tuple(scene_.ambient) +
         (scene_.has_default_ambient ? "   the sum of the lights' intensities, since none is given"
                                     : "   as given"));
    for (int c = 0; c < 3; ++c) {
      line(std::string("  ambient ") + kChannels[c] + " = ka Ia = " + num(material().ka[c]) +
           " * " + num(scene_.ambient[c]) + " = " + num(terms().ambient[c]));
    }
  }

  void write_indirect() {
    heading("Indirect: I = kd E, in place of ambient light");
    for (std::size_t b = 0; b < e_.by_bounce.size() && layer_ == &e_.layers[0]; ++b) {
      line("  E" + std::to_string(b + 1) + " = " + tuple(e_.by_bounce[b]) +
           "   the part of bounce " + std::to_string(b + 1));
    }
    line("  E = " + tuple(terms().irradiance) + "   what arrives from surfaces and sky");
    if (layer_ == &e_.layers[0]) write_senders();
    for (int c = 0; c < 3; ++c) {
      line(std::string("  indirect ") + kChannels[c] + " = kd E = " + num(material().kd[c]) +
           " * " + num(terms().irradiance[c]) + " = " + num(terms().indirect[c]));
    }
  }

  void write_senders() {
    const auto percent = [](double share) { return num(std::round(1e3 * share) / 10) + " %"; };
    const FirstBounce& first = e_.first_bounce;
    if (first.light == 0) return;
    line("  Where the first bounce comes from, by 2048 fixed rays (which bring " +
         num(first.light) + "), the brightest places first:");
    for (const Sender& sender : first.senders) {
      line("    " + percent(sender.share) + " from surface " + std::to_string(sender.surface) +
           " at " + tuple(sender.position) + ", " +
           num(length(sender.position - terms().point.position)) + " mm away");
    }
    if (first.sky_share > 0) line("    " + percent(first.sky_share) + " from the open sky");
  }

  void write_light(std::size_t n) {
    const Light& light = scene_.lights[n];
    const LightTerms& t = terms().lights[n];
    const SurfacePoint& point = terms().point;
    const bool is_point = light.kind == Light::Kind::kPoint;
    heading("Light " + std::to_string(n) + ": " +
            (is_point ? "a point light at P = " : "a directional light, towards D = ") +
            tuple(light.place) + ", intensity I = " + tuple(light.intensity) +
            (scene_.has_default_light ? " (the headlight, since no light is given)" : ""));
    const char* offset = is_point ? "P - p" : "D";
    if (is_point) {
      line("  P - p = " +
           each_axis([&](int a) { return num(light.place[a]) + " - " + arg(point.position[a]); }) +
           " = " + tuple(t.offset));
    }
    line(std::string("  |") + offset + "| = sqrt(" + arg(t.offset.x) + "^2 + " + arg(t.offset.y) +
         "^2 + " + arg(t.offset.z) + "^2) = " + num(t.distance));
    if (t.distance == 0) {
      line("  The light lies in the surface itself and lights it from no direction: it adds 0.");
      return;
    }
    line(std::string("  l = ") + (is_point ? "(P - p) / |P - p|" : "D / |D|") + " = " +
         each_axis([&](int a) { return num(t.offset[a]) + " / " + num(t.distance); }) + " = " +
         tuple(t.to_light));
    line("  cos θ = n · l = " + dot_text(point.normal, t.to_light) + " = " + num(t.cos_theta));
    line("  θ = acos(" + num(t.cos_theta) + ") = " + num(degrees(t.cos_theta)) + "°");
    line("  r = 2 (n · l) n - l = " + each_axis([&](int a) {
           return "2 * " + arg(t.cos_theta) + " * " + arg(point.normal[a]) + " - " +
                  arg(t.to_light[a]);
         }) +
         " = " + tuple(t.reflected));
    line("  cos φ = r · e = " + dot_text(t.reflected, point.to_eye) + " = " + num(t.cos_phi));
    line("  φ = acos(" + num(t.cos_phi) + ") = " + num(degrees(t.cos_phi)) + "°");
    if (light.inverse_square_reference_mm) {
      line("  falloff = (reference / |P - p|)^2 = (" + num(*light.inverse_square_reference_mm) +
           " / " + num(t.distance) + ")^2 = " + num(t.falloff));
    }
    if (scene_.shadows && t.cos_theta > 0) {
      line("  V = " + num(t.visibility) + "   the share of the light that " +
           (t.visibility == 1   ? "arrives: nothing is in its way"
            : t.visibility == 0 ? "arrives: the point lies in shadow"
                                : "comes through translucent surfaces"));
    }
    write_diffuse(light, t);
    write_specular(light, t);
  }

  // The factors on a light's intensity: their names, and their numbers.
  struct Factors {
    std::string names, numbers;
  };
  Factors factors(const Light& light, const LightTerms& t) const {
    Factors f;
    if (scene_.shadows) {
      f.names += " V";
      f.numbers += " * " + num(t.visibility);
    }
    if (light.inverse_square_reference_mm) {
      f.names += " falloff";
      f.numbers += " * " + num(t.falloff);
    }
    return f;
  }

  void write_diffuse(const Light& light, const LightTerms& t) {
    if (t.cos_theta <= 0) line("  The clamp acts: n · l <= 0, the light is behind the surface.");
    const Factors f = factors(light, t);
    for (int c = 0; c < 3; ++c) {
      line(std::string("  diffuse ") + kChannels[c] + " = kd I max(0, n · l)" + f.names + " = " +
           num(material().kd[c]) + " * " + num(light.intensity[c]) + " * max(0, " +
           num(t.cos_theta) + ")" + f.numbers + " = " + num(t.diffuse[c]));
    }
  }

  void write_specular(const Light& light, const LightTerms& t) {
    if (t.cos_theta <= 0) {
      line("  specular = (0, 0, 0)   Phong's term is only there where n · l > 0");
      return;
    }
    if (t.cos_phi <= 0) line("  The clamp acts: r · e <= 0, the mirror direction points away.");
    const Factors f = factors(light, t);
    for (int c = 0; c < 3; ++c) {
      line(std::string("  specular ") + kChannels[c] + " = ks I max(0, r · e)^n" + f.names + " = " +
           num(material().ks[c]) + " * " + num(light.intensity[c]) + " * max(0, " + num(t.cos_phi) +
           ")^" + num(material().shininess) + f.numbers + " = " + num(t.specular[c]));
    }
  }

  void write_sum() {
    const bool is_indirect = scene_.indirect != IndirectMethod::kOff;
    heading(std::string("Sum: ") + (is_indirect ? "indirect" : "ambient") +
            ", and diffuse and specular of every light");
    for (int c = 0; c < 3; ++c) {
      std::string sum = num(is_indirect ? terms().indirect[c] : terms().ambient[c]);
      for (const LightTerms& t : terms().lights) {
        sum += " + " + num(t.diffuse[c]) + " + " + num(t.specular[c]);
      }
      line(std::string("  I ") + kChannels[c] + " = " + sum + " = " + num(terms().total[c]));
    }
  }

  void write_display() {
    const bool raw = scene_.display.curve == Display::Curve::kRaw;
    line(std::string("Display: 255 times ") + (raw ? "" : "the sRGB curve of ") +
         "exposure times I, clamped to 0..1 and rounded to nearest (I as the picture has it, a "
         "32-bit float)");
    for (int c = 0; c < 3; ++c) {
      const double exposed = scene_.display.exposure * e_.radiance[c];
      const double clamped = std::fmin(1, std::fmax(0, transfer(scene_.display, exposed)));
      const std::string product = num(scene_.display.exposure) + " * " + num(e_.radiance[c]);
      line(std::string("  shown ") + kChannels[c] + " = 255 * min(1, max(0, " +
           (raw ? product : "srgb(" + product + ")") + ")) = " + num(255 * clamped) + " -> " +
           std::to_string(e_.shown[static_cast<std::size_t>(c)]));
    }
  }

  const Scene& scene_;
  const Explanation& e_;
  const ExplainedLayer* layer_;  // the one that is written
  std::string text_;
};

}  // namespace

std::string explain_text(const Scene& scene, const Explanation& explanation,
                         const std::vector<std::string>& surface_names) {
  return Writer(scene, explanation).write(surface_names);
}

}  // namespace isolux
