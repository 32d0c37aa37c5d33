# bash completion for sonopack. The options come from `sonopack COMMAND --help`, so they are never out of date.

_sonopack_options() {
    "$1" "$2" --help 2>/dev/null | grep -oE -- '(^|[ ,])--[a-z][a-z0-9-]*' | tr -d ' ,' | sort -u
}

_sonopack() {
    local program=${COMP_WORDS[0]} current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]}
    local commands='pack check statics moduli modes spectrum signal front wave study table reproduce chain column plot convert bench help'
    local command='' word
    COMPREPLY=()
    for word in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do
        case $word in
        -*) ;;
        *)
            command=$word
            break
            ;;
        esac
    done
    if [ -z "$command" ]; then
        mapfile -t COMPREPLY < <(compgen -W "$commands --help --version" -- "$current")
        return
    fi
    case $previous in
    --units)
        mapfile -t COMPREPLY < <(compgen -W 'own si' -- "$current")
        return
        ;;
    --format)
        mapfile -t COMPREPLY < <(compgen -W 'tsv csv json' -- "$current")
        return
        ;;
    --source)
        mapfile -t COMPREPLY < <(compgen -W 'impulse velocity displacement' -- "$current")
        return
        ;;
    --initial)
        mapfile -t COMPREPLY < <(compgen -W 'A B' -- "$current")
        return
        ;;
    --figures)
        mapfile -t COMPREPLY < <(compgen -W 'svg png pdf' -- "$current")
        return
        ;;
    --protocol)
        mapfile -t COMPREPLY < <(compgen -W 'default somfai2005 quick' -- "$current")
        return
        ;;
    --only)
        if [[ " ${COMP_WORDS[*]} " == *" blackmore2011 "* ]]; then
            mapfile -t COMPREPLY < <(compgen -W 'errata fig1 fig2 symbols chaos claims' -- "$current")
            return
        fi
        mapfile -t COMPREPLY < <(compgen -W "$(printf 'table%s ' 1 2 3 4 5) $(printf 'fig%s ' {1..12}) claims" -- "$current")
        return
        ;;
    --norm)
        mapfile -t COMPREPLY < <(compgen -W 'grain one modes' -- "$current")
        return
        ;;
    --direction)
        mapfile -t COMPREPLY < <(compgen -W 'x up' -- "$current")
        return
        ;;
    --component)
        mapfile -t COMPREPLY < <(compgen -W 'normal shear' -- "$current")
        return
        ;;
    --method)
        if [ "$command" = spectrum ]; then
            mapfile -t COMPREPLY < <(compgen -W 'auto exact kpm count' -- "$current")
            return
        fi
        mapfile -t COMPREPLY < <(compgen -W 'auto chebyshev dense sparse verlet lax-wendroff faber dynamics' -- "$current")
        return
        ;;
    esac
    case $command in
    help) mapfile -t COMPREPLY < <(compgen -W "$commands scene" -- "$current") ;;
    *)
        if [[ $current == -* ]]; then
            mapfile -t COMPREPLY < <(compgen -W "$(_sonopack_options "$program" "$command")" -- "$current")
        elif [ "$command" = table ] && [ "$previous" = table ]; then
            mapfile -t COMPREPLY < <(compgen -W 'ctof scaling planes statics moduli probes spectrum ensemble signal' -- "$current")
        elif [ "$command" = reproduce ] && [ "$previous" = reproduce ]; then
            mapfile -t COMPREPLY < <(compgen -W 'somfai2005 blackmore2011' -- "$current")
        elif [ "$command" = bench ]; then
            mapfile -t COMPREPLY < <(compgen -W 'signal long many damped modes moduli pack' -- "$current")
        elif [ "$command" = plot ] && [ "$previous" = plot ]; then
            mapfile -t COMPREPLY < <(compgen -W 'ctof signal network stiffness angles forces snapshot fronts scaling
                ensemble pareto spectrum dispersion wave column mode modes' -- "$current")
        elif [ "$command" = chain ] && [ "$previous" = chain ]; then
            mapfile -t COMPREPLY < <(compgen -W 'front signal modes' -- "$current")
        elif [ "$command" = spectrum ] && [ "$previous" = spectrum ]; then
            mapfile -t COMPREPLY < <(compgen -W 'dos transmission dispersion harmonic participation
                continuum' -- "$current")
        else
            compopt -o filenames 2>/dev/null
            mapfile -t COMPREPLY < <(compgen -f -- "$current")
        fi
        ;;
    esac
}

complete -F _sonopack sonopack
