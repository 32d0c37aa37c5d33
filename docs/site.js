// Formulas, which stand in the pages between \( \) and \[ \].
window.addEventListener("load", () => renderMathInElement(document.body, {
    delimiters: [{left: "\\[", right: "\\]", display: true}, {left: "\\(", right: "\\)", display: false}]}));
