// What the page of `sonopack view' uses of three.js.
export { BufferAttribute, BufferGeometry, DataTexture, DoubleSide, FloatType, GLSL3, LineBasicMaterial, LineSegments, Mesh,
  MOUSE, NearestFilter, OrthographicCamera, RawShaderMaterial, RGBAFormat, Scene, TOUCH, Vector3, WebGLRenderer } from 'three';
export { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
