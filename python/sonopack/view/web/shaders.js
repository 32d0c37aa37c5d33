/* What the graphics card does: grains are drawn as discs or as exact spheres on squares that face the viewer, contacts as
 * ribbons. All of them are one mesh each, of four corners a grain or contact: as instances they take ten times as long
 * where a processor stands in for the card. Their numbers are in textures, so that contacts follow their grains. */

const shared = `precision highp float;
precision highp int;
precision highp sampler2D;
`;

const fetching = `uniform sampler2D place; // centre, radius
uniform sampler2D look;  // colour value or -1, kind (-1 hidden, 0 grain, 1 rattler, 2 chosen), angle
uniform int columns;
uniform mat4 modelViewMatrix;
uniform mat4 projectionMatrix;
ivec2 texel(int at) { return ivec2(at % columns, at / columns); }
`;

export const grainVertex = `${shared}${fetching}
uniform float size;
out vec2 corner;
flat out vec4 looks;
flat out vec4 centre; // in the space of the camera, and the radius shown
void main() {
  ivec2 from = texel(gl_VertexID / 4);
  int k = gl_VertexID % 4;
  vec4 grain = texelFetch(place, from, 0);
  looks = texelFetch(look, from, 0);
  corner = 1.05 * vec2(k == 1 || k == 2 ? 1.0 : -1.0, k > 1 ? 1.0 : -1.0);
  vec4 at = modelViewMatrix * vec4(grain.xyz, 1.0);
  centre = vec4(at.xyz, grain.w * size);
  at.xy += corner * centre.w;
  gl_Position = looks.y < -0.5 ? vec4(2.0, 2.0, 2.0, 1.0) : projectionMatrix * at;
}
`;

export const grainFragment = `${shared}
uniform mat4 projectionMatrix;
uniform sampler2D scale;
uniform vec3 plain, rattler, edge, chosen, ground;
uniform float marks; // 1: a line on each disc that turns with it
uniform vec2 depths; // of the packing in front of the camera: near, far
in vec2 corner;
flat in vec4 looks;
flat in vec4 centre;
out vec4 colour;
void main() {
  float r = length(corner), blur = fwidth(r);
  if (r > 1.0 + blur) discard;
  bool still = looks.y > 0.5 && looks.y < 1.5, picked = looks.y > 1.5;
  vec3 base = still ? rattler : looks.x >= 0.0 ? texture(scale, vec2(looks.x * 0.996 + 0.002, 0.5)).rgb : plain;
  if (picked) base = mix(base, chosen, 0.7);
#ifdef SOLID
  float z = sqrt(max(0.0, 1.0 - r * r));
  float light = max(0.0, dot(vec3(corner, z), normalize(vec3(-0.35, 0.5, 0.8))));
  float depth = centre.z + z * centre.w;
  base *= 0.42 + 0.62 * light;
  float far = clamp((-depth - depths.x) / (depths.y - depths.x), 0.0, 1.0);
  base = mix(base, ground, 0.45 * far);
  vec4 clip = projectionMatrix * vec4(centre.xy, depth, 1.0);
  gl_FragDepth = 0.5 * clip.z / clip.w + 0.5;
#else
  // small discs have neither rim nor mark: these would hide the colours
  float large = smoothstep(3.0, 8.0, 1.0 / blur), rim = smoothstep(0.9 - blur, 0.9 + blur, r);
  float on = 0.0;
  if (marks > 0.5 && !still && large > 0.0) {
    vec2 along = vec2(cos(looks.z), sin(looks.z));
    float across = abs(along.x * corner.y - along.y * corner.x);
    on = step(0.0, dot(along, corner)) * (1.0 - smoothstep(0.04, 0.04 + 2.0 * blur, across));
  }
  base = mix(base, edge, 0.55 * large * max(rim, on));
#endif
#ifdef HARD
  if (r > 1.0) discard;
  colour = vec4(base, 1.0);
#else
  colour = vec4(base, 1.0 - smoothstep(1.0 - blur, 1.0 + 0.2 * blur, r));
#endif
}
`;

export const contactVertex = `${shared}${fetching}
uniform sampler2D links;  // two texels a contact: grains (the second -1 at a wall), share of the way that is drawn, 0 if
                          // it carries no force; then where the copy of the second grain is, or the point at a wall
uniform sampler2D shapes; // width or -1, colour value
uniform float width, least, raised;
out float across;
out float depth;
flat out vec2 value;
void main() {
  int c = gl_VertexID / 4, k = gl_VertexID % 4;
  vec4 link = texelFetch(links, texel(2 * c), 0);
  vec2 shape = texelFetch(shapes, texel(c), 0).xy;
  ivec2 first = texel(int(link.x + 0.5));
  vec3 from = texelFetch(place, first, 0).xyz, to = texelFetch(links, texel(2 * c + 1), 0).xyz;
  bool hidden = texelFetch(look, first, 0).y < -0.5;
  if (link.y >= -0.5) {
    ivec2 second = texel(int(link.y + 0.5));
    to += texelFetch(place, second, 0).xyz;
    hidden = hidden || texelFetch(look, second, 0).y < -0.5;
  }
  to = mix(from, to, link.z);
  vec4 a = modelViewMatrix * vec4(from, 1.0), b = modelViewMatrix * vec4(to, 1.0);
  vec2 way = b.xy - a.xy;
  vec2 side = length(way) > 1e-6 ? normalize(vec2(-way.y, way.x)) : vec2(1.0, 0.0);
  vec4 at = k == 1 || k == 2 ? b : a;
  across = k > 1 ? 1.0 : -1.0;
  at.xy += side * across * max(least, 0.5 * width * shape.x);
  at.z += raised;
  depth = -at.z;
  value = vec2(shape.y, link.w);
  gl_Position = hidden || shape.x < 0.0 ? vec4(2.0, 2.0, 2.0, 1.0) : projectionMatrix * at;
}
`;

export const contactFragment = `${shared}
uniform sampler2D scale;
uniform vec3 weak, ground;
uniform vec2 depths;
in float across;
in float depth;
flat in vec2 value;
out vec4 colour;
void main() {
  vec3 base = value.y > 0.5 ? texture(scale, vec2(value.x * 0.996 + 0.002, 0.5)).rgb : weak;
#ifdef SOLID
  base *= 0.55 + 0.5 * sqrt(max(0.0, 1.0 - across * across));
  base = mix(base, ground, 0.45 * clamp((depth - depths.x) / (depths.y - depths.x), 0.0, 1.0));
#endif
#ifdef SOLID
  colour = vec4(base, 1.0);
#else
  colour = vec4(base, min(1.0, (1.0 - abs(across)) / fwidth(across) + 0.3));
#endif
}
`;
